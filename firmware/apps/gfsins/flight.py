"""The navigation task: each good packet into alignment, then into the filters, and what is due behind it."""

from __future__ import annotations

from functools import partial
from typing import Final

from firmware.apps.gfsins.acquisition_news import AcquisitionNews
from firmware.apps.gfsins.alignment import Alignment
from firmware.apps.gfsins.coefficients import Coefficients
from firmware.apps.gfsins.entered import certainty, entered_beginning
from firmware.apps.gfsins.equivalent_feed import EquivalentFeed
from firmware.apps.gfsins.lost_attitude import LostAttitude
from firmware.apps.gfsins.navigation import Navigation
from firmware.apps.gfsins.reception import Reception
from firmware.apps.gfsins.sensor_flags import SensorFlags
from firmware.apps.gfsins.settings import Settings
from firmware.apps.gnss_ins.output import Output
from firmware.nav.gyro_free import packet as pk
from firmware.nav.gyro_free.filters import Beginning
from firmware.nav.gyro_free.packet_door import FUSED
from hal.board_io import BoardIo
from hal.machine_code import mypyc_attr

SECOND_NS: Final = 1_000_000_000
SLOW_FRAMES_TICKS: Final = 8
"""What goes to the host once a second holds its line for less than that."""
LONGEST_GAP_NS: Final = 2 * SECOND_NS
"""Without packets; what nine accelerometers make of the rate is worth nothing behind it."""


@mypyc_attr(allow_interpreted_subclasses=True)
class Flight:
    """From packets to solutions."""

    def __init__(
        self,
        io: BoardIo,
        settings: Settings,
        navigation: Navigation,
        reception: Reception,
        news: AcquisitionNews,
        output: Output,
        sensor_flags: SensorFlags,
    ) -> None:
        self.is_aligned = False
        self.beginning: tuple[float, float, float] | None = None
        """Yaw, pitch, roll to be told to the FPGA."""
        self.is_entered_refused = False
        """Whether what an operator entered is not of here."""
        self.oldest_ns = 0
        """Worst age of a tick when its solution was there."""
        self.ages_ns = 0
        """Sum of these ages …"""
        self.realignments = 0
        """How often attitude was lost …"""
        self.lost_by = ""
        """… and by what, the last time."""
        self._tick_ns = 0
        self.restarts = 0
        """How often the master had lost its state."""
        self.solutions = 0
        """… and how many there were."""
        self.coefficients = Coefficients(navigation.federation.g)
        self._navigation = navigation
        self._reception = reception
        self._news = news
        self._output = output
        self._note = sensor_flags.note
        self._clock = io.clock
        self._spend = io.cpu.spend
        cost = io.cpu.cost
        self._costs = cost("packet_step"), cost("compass_step"), cost("gps_step"), cost("fusion_step")
        self._align_cost = cost("gather_rest")
        equivalent = settings.feed == "equivalent"
        self._feed = EquivalentFeed(io.spi["equivalent"] if equivalent else None)
        needed_ns = round(settings.alignment_s * SECOND_NS)
        self._new_alignment = partial(Alignment, navigation.federation, needed_ns, not equivalent)
        self.alignment = self._new_alignment()
        self._uses_registers = not equivalent
        self._lost = LostAttitude(navigation.federation)
        self._output_line = io.interrupts.attach("output", output.send)
        self._epoch_line = io.interrupts.attach("epoch_output", output.send_epoch)
        self._entered = settings.entered
        self._ticks_per_output = settings.ticks_per_output
        self._ticks = 0

    @property
    def is_solution_near(self) -> bool:
        """Whether the next solution would have to wait for slow frames that went to the host now."""
        near = min(SLOW_FRAMES_TICKS, self._ticks_per_output - 1)
        return self.is_aligned and self._ticks_per_output - self._ticks <= near

    def begin(self) -> None:
        """Take packets from now on."""
        self._reception.begin(self._take)

    def _take(self) -> None:
        words = self._reception.words
        self._navigation.samples_missed = self._reception.lost
        flags, tick_ns = self._reception.numbers[pk.FLAGS], self._reception.tick_ns
        if flags:
            self._note(flags, tick_ns)
        gap_ns, self._tick_ns = tick_ns - self._tick_ns, tick_ns
        if not self.is_aligned:
            self._align()
            return
        if gap_ns > LONGEST_GAP_NS and self._uses_registers:
            self._align_again(f"no packets for {gap_ns / SECOND_NS:.0f} s")
            return
        self._feed.read()
        navigation = self._navigation
        if not navigation.has_state:
            self.restarts += navigation.begin_again(self._reception.tick_ns - 1000)
        done: int = navigation.door.take(words, self._feed.felt)
        step, compass, gps, fusion = self._costs
        if flags & pk.HAS_COMPASS:
            step += compass
            if self._uses_registers and not words[pk.FAULTS] and self._lost.look():
                self._align_again("compass or GPS contradicts")
                return
        if flags & pk.HAS_GPS:
            step += gps
            self._news.epochs += 1
            self._epoch_line.pend()
        if done & FUSED:
            step += fusion
        self._spend(step)
        self._note_age()
        self._ticks += 1
        if self._ticks >= self._ticks_per_output:
            self._ticks = 0
            self._output_line.pend()

    def _align_again(self, cause: str) -> None:
        self.realignments += 1
        self.lost_by = cause
        self._navigation.forget()
        self.alignment = self._new_alignment()
        self.is_aligned = False

    def _align(self) -> None:
        reception = self._reception
        if not self.coefficients.take(reception.words):
            return
        begun = self.alignment.take(reception.words, reception.tick_ns)
        self._spend(self._align_cost)
        if begun is not None:
            begun = self._start(begun)
            self.beginning = begun.angles
            self.is_aligned = True

    def _start(self, found: Beginning) -> Beginning:
        """With what was entered, if that is of here; once."""
        entered, self._entered = self._entered, {}
        known = entered_beginning(found, entered)
        self.is_entered_refused = known is None
        begun = found if known is None else known
        self._navigation.start(begun, certainty(entered) if known is not None else None)
        return begun

    def _note_age(self) -> None:
        age_ns = self._clock.now_ns() - self._reception.tick_ns
        self.ages_ns += age_ns
        self.solutions += 1
        self.oldest_ns = max(self.oldest_ns, age_ns)
