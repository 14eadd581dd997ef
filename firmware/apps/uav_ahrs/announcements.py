"""What people at the host are told in words: changes of mode, trouble of sensor and bus, its end.

Trouble is said when it begins and when it has ended (QUIET_LOOKS looks without it); the same again at the
earliest AGAIN_NS later. Numbers belong to STATUS and SENSOR.
"""

from __future__ import annotations

from firmware.apps.uav_ahrs.attitude import Attitude
from firmware.apps.uav_ahrs.disagreement import LIMIT
from firmware.apps.uav_ahrs.output import Output
from firmware.apps.uav_ahrs.plausibility import FROZEN_READS, JUMPS
from firmware.apps.uav_ahrs.sensor import Sensor
from firmware.nav import flags as modes
from firmware.nav.attitude import flags as fl
from hal.clock import Clock

AGAIN_NS = 10_000_000_000
QUIET_LOOKS = 10
"""1 s."""
SEVERAL = 3
"""So often between two looks (25 reads) something is no single bit error."""
CLOCK_PPM = 3_000
FEW_A_SECOND = 2
"""Bursts refused in a second, from which on the bus is called disturbed."""

LARGEST_BIAS = 8_726_646
"""1e-9 rad/s: 0.5 °/s; after an auto-null it is a hundredth of that."""
TRIADS = ("gyro", "accelerometer", "magnetometer")
STILL_READS = int(FROZEN_READS)
"""A second without the least change: noise alone moves each output."""

TROUBLE = {
    "stale": ("sensor: no new samples", "sensor: new samples again"),
    "supply": ("sensor: supply out of range", "sensor: supply in range again"),
    "gyro_saturated": ("sensor: rate beyond its range", "sensor: rate within its range again"),
    "no_answer": ("sensor: no answer", "sensor: answers again"),
    "slipped": ("bus: words have slipped", "bus: words in their places again"),
    "field_implausible": ("sensor: magnetic field missing or disturbed", "sensor: magnetic field is back"),
    "moved": ("alignment: not at rest", ""),
    "rates_lost": ("rates lost, attitude uncertain", "rates are back"),
    "overrun": ("samples overrun the attitude task", ""),
    "yaw_given": ("no magnetic field: heading as given", ""),
    "gyro_bias": ("sensor: gyro bias beyond 0.5 deg/s", "sensor: gyro bias small again"),
    "disagreement": ("gyros contradict force and field", "gyros, force and field agree again"),
    "force_saturated": ("sensor: force beyond its range", "sensor: force within its range again"),
    **{f"still_{name}": (f"sensor: {name} frozen", f"sensor: {name} moves again") for name in TRIADS},
}
"""By notice: what is said at its beginning and at its end."""


class Announcer:
    """Looks at what was noticed since the last look, and says what is new."""

    def __init__(self, clock: Clock, attitude: Attitude, output: Output) -> None:
        self._clock = clock
        self._attitude = attitude
        self._output = output
        self._mode = 0
        self._counts = attitude.notices()
        self._told: dict[str, int] = {}
        """Trouble that stands, and looks since it was last seen."""
        self._said_ns: dict[str, int] = {}
        self._refused = 0
        self._forces = 0
        self._spoilt = 0

    def look(self) -> None:
        """From the background, ten times a second."""
        output = self._output
        if output.mode != self._mode:
            self._mode = output.mode
            output.send_text(f"mode: {modes.MODE_NAMES[self._mode]}")
        counts = self._attitude.notices()
        if counts != self._counts or self._told:
            self._look_at_counts(counts)
        for name, reads in zip(TRIADS, self._attitude.still_reads(), strict=True):
            if reads > STILL_READS or self._told:
                self._tell(f"still_{name}", SEVERAL if reads > STILL_READS else 0)
        if output.gyro_bias > LARGEST_BIAS or self._told:
            self._tell("gyro_bias", SEVERAL if output.gyro_bias > LARGEST_BIAS else 0)
        disagrees = self._attitude.disagreement() > LIMIT
        if disagrees or self._told:
            self._tell("disagreement", SEVERAL if disagrees else 0)
        if disagrees:
            output.doubt()
        forces = self._attitude.forces_held()
        if forces != self._forces or self._told:
            self._tell("force_saturated", forces - self._forces)
            self._forces = forces
        if output.spoilt != self._spoilt:
            self._spoilt = output.spoilt
            output.send_text("state not a number, the last sound one put back")

    def _look_at_counts(self, counts: list[int]) -> None:
        for name, now, before in zip(fl.NOTICE_NAMES, counts, self._counts, strict=True):
            if name in TROUBLE:
                self._tell(name, now - before)
        self._counts = counts

    def look_at_bus(self) -> None:
        """Once a second: how many bursts contradicted those before?"""
        refused = int(self._attitude.k[JUMPS])
        grown, self._refused = refused - self._refused, refused
        if grown >= FEW_A_SECOND:
            self._say(f"bus disturbed: {grown} bursts refused in a second", "refused")

    def look_at_clock(self, sensor: Sensor) -> None:
        """Once a second: does the sensor sample at its rate?"""
        phase = sensor.phase
        if not phase.is_settled:
            return
        off = abs(phase.error_ppm) > CLOCK_PPM
        if off and "clock" not in self._told:
            self._told["clock"] = 0
            self._output.send_text(f"sensor: sample clock off by {phase.error_ppm} ppm")
        elif not off and self._told.pop("clock", None) is not None:
            self._output.send_text("sensor: sample clock right again")

    def _tell(self, name: str, often: int) -> None:
        begins, ends = TROUBLE[name]
        least = 1 if name in ("moved", "yaw_given", "overrun") else SEVERAL
        if name in self._told:
            self._told[name] = 0 if often else self._told[name] + 1
            if self._told[name] >= QUIET_LOOKS:
                del self._told[name]
                if ends:
                    self._output.send_text(ends)
        elif often >= least and self._say(begins, name):
            self._told[name] = 0

    def _say(self, words: str, key: str) -> bool:
        now_ns = self._clock.now_ns()
        if now_ns - self._said_ns.get(key, -AGAIN_NS) < AGAIN_NS:
            return False
        self._said_ns[key] = now_ns
        self._output.send_text(words)
        return True
