"""What people at the host are told in words: changes of mode, alarms of navigation, receiver and card.

Alarms count from the first navigation on. Each is said when it begins, and again at the earliest AGAIN_NS
later; whether it still stands is in the flags of every solution. Numbers belong to the STATUS frame.
"""

from __future__ import annotations

from typing import Final

from firmware.apps.gnss_ins.output import Output
from firmware.apps.gnss_ins.parts import Receiver
from firmware.nav import flags
from hal.clock import Clock
from hal.machine_code import mypyc_attr

AGAIN_NS: Final = 10_000_000_000
BAD_BYTES: Final = 20
"""Bytes in one look that made no message, from which on the line is called disturbed."""
PORT_ERROR_WEIGHT: Final = 10
"""Framing errors and overruns in such bytes: a good line has none, a single one may be a spike."""
GOOD_LOOKS: Final = 3
"""Looks without an error in a row after which the line is called good again."""

ALARMS = {
    flags.GNSS_TIME_JUMP: "GNSS time has jumped",
    flags.GNSS_REJECTED: "GNSS refused, it contradicts the solution",
    flags.GNSS_STALE: "GNSS epoch too old",
    flags.IMU_GAP: "IMU samples missing",
    flags.IMU_SATURATED: "IMU out of range",
    flags.IMU_STUCK: "IMU frozen",
    flags.IMU_NOT_FINITE: "IMU sample not a number",
    flags.NUMERIC_RESTART: "state not a number, navigation restarted",
    flags.REALIGNED: "heading contradicted by the course, aligning again",
    flags.REJOINED: "GNSS believed again after long refusal",
    flags.GNSS_LOST: "GNSS lost",
    flags.POSITION_UNCERTAIN: "position uncertain",
}


@mypyc_attr(allow_interpreted_subclasses=True)
class Announcer:
    """Looks at what the last output said, and says what is new."""

    def __init__(self, clock: Clock, receiver: Receiver, output: Output) -> None:
        self._clock = clock
        self._modes = flags.MODE_NAMES
        self._receiver = receiver
        self._output = output
        self._mode = 0
        self._flags = 0
        self._said_ns: dict[int, int] = {}
        self._phase = receiver.phase_name
        self._bad_bytes = 0
        self._bad_said_ns = -AGAIN_NS
        self._line_is_bad = False
        self._good_looks = 0
        self._card_works = True
        self._has_navigated = False

    def look(self) -> None:
        """From the background, after its other work."""
        output = self._output
        if output.mode != self._mode:
            self._mode = output.mode
            self._has_navigated |= self._mode == flags.NAVIGATING
            output.send_text(f"mode: {self._modes[self._mode]}")
        if output.flags != self._flags and self._has_navigated:
            self._tell_alarms(output.flags)
        if self._receiver.phase_name != self._phase:
            self._phase = self._receiver.phase_name
            output.send_text(f"receiver: {self._phase}")
        if output.card_works != self._card_works:
            self._card_works = output.card_works
            output.send_text("card: writing" if self._card_works else "card: cannot be written")

    def look_at_line(self) -> None:
        """Once a second: is what comes from the receiver full of errors?"""
        bad_checksums, garbage = self._receiver.line_errors()
        port_errors, is_running = self._receiver.port_errors, self._receiver.is_running
        bad = bad_checksums * BAD_BYTES + garbage + port_errors * PORT_ERROR_WEIGHT
        grown, self._bad_bytes = bad - self._bad_bytes, bad
        now_ns = self._clock.now_ns()
        if grown >= BAD_BYTES and is_running and now_ns - self._bad_said_ns >= AGAIN_NS:
            self._bad_said_ns = now_ns
            self._line_is_bad = True
            counts = f"{bad_checksums} bad checksums, {garbage} bytes of garbage, {port_errors} port errors"
            self._output.send_text(f"receiver line disturbed: {counts} so far")

        self._good_looks = 0 if grown else self._good_looks + 1
        if self._line_is_bad and self._good_looks >= GOOD_LOOKS and is_running:
            self._line_is_bad = False
            self._output.send_text("receiver line is good again")

    def _tell_alarms(self, word: int) -> None:
        new, ended = word & ~self._flags, self._flags & ~word
        self._flags = word
        now_ns = self._clock.now_ns()
        for flag, words in ALARMS.items():
            if new >> flag & 1 and now_ns - self._said_ns.get(flag, -AGAIN_NS) >= AGAIN_NS:
                self._said_ns[flag] = now_ns
                self._output.send_text(words)
        if ended >> flags.GNSS_LOST & 1:
            self._output.send_text("GNSS is back")
