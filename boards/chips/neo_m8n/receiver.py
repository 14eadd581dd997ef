"""The NEO-M8N as one object: supply, start-up, navigation epochs, commands.

At a start the port prints the start-up texts, then comes one set of messages per navigation epoch. Epochs lie
on multiples of the navigation period in GPS (or UTC) time.

What is modelled, what is not, and the choices made stand in docs/fidelity/neo_m8n.md.
"""

from __future__ import annotations

from functools import partial
from struct import unpack

from boards.chips.neo_m8n import settings as cfg
from boards.chips.neo_m8n import timepulse
from boards.chips.neo_m8n.catalogue import BINARY, SENTENCES
from boards.chips.neo_m8n.commands import obey
from boards.chips.neo_m8n.configure import (
    GNSS_ONLY,
    GNSS_START,
    GNSS_STOP,
    HARDWARE_NOW,
    Configurator,
    Restart,
)
from boards.chips.neo_m8n.configure_systems import fix_mode
from boards.chips.neo_m8n.engine import Engine, StartState
from boards.chips.neo_m8n.input_parser import InputParser, UbxInput
from boards.chips.neo_m8n.nmea import TXT_WARNING
from boards.chips.neo_m8n.output import PROTOCOL_NMEA, PROTOCOL_UBX, Output
from boards.chips.neo_m8n.settings import Settings
from boards.chips.neo_m8n.solution import Solution
from boards.chips.neo_m8n.timepulse import TimePulse
from boards.chips.neo_m8n.ubx import CLASS_CFG, acknowledge
from boards.chips.receivers.receiver import Receiver, check_start_state
from boards.chips.receivers.sentence_input import Sentence
from boards.chips.receivers.transmitter import BUFFER_BYTES
from boards.chips.receivers.utc import SECOND
from boards.chips.registers import ReportKind
from boards.chips.transmit_line import TransmitLine
from boards.chips.world import GnssEpoch, GnssWorld
from hal.emulated.virtual_time import VirtualTime

BOOT_NS = 250_000_000
"""From the supply (or a reset) to the first text; a choice, the fact sheet has no figure."""
SHORTEST_PERIOD_MS = 200
SHORTEST_PERIOD_SINGLE_MS = 100
"""With several satellite systems 5 Hz, with one 10 Hz (fact sheet section 1); faster settings run at that."""
DEFAULT_LEAP_SECONDS = 18
TIME_REFERENCE_UTC = 0


class NeoM8n(Receiver[Solution]):
    """The receiver. `receive` is its RXD pin, `tx` the wire at TXD, `pins["TIMEPULSE"]` an output net.

    `start_state` is what the first start finds ("cold", "warm", "hot"). Later starts follow from how long
    the supply was off; without `backup_supply` they are cold and settings saved in battery-backed memory
    only are lost. `powered=False` leaves the supply off until `power(True)`.
    """

    boot_ns = BOOT_NS

    def __init__(
        self,
        time: VirtualTime,
        world: GnssWorld,
        tx: TransmitLine,
        *,
        start_state: StartState = "cold",
        powered: bool = True,
        backup_supply: bool = True,
        default_leap_seconds: int = DEFAULT_LEAP_SECONDS,
        tx_buffer_bytes: int = BUFFER_BYTES,
        strict: bool = False,
    ) -> None:
        check_start_state("NEO-M8N", start_state)
        self._settings = Settings()
        self._output = Output(time, tx, self._settings, tx_buffer_bytes)
        super().__init__(time, world, self._output.transmitter, "NEO-M8N", strict=strict)
        self.pins["TIMEPULSE"] = None
        self._next_state: StartState = start_state
        self._backup_supply = backup_supply
        self._configurator = Configurator(self._settings, self._report)
        self._engine = Engine(default_leap_seconds)
        self._pulse = TimePulse(time)
        self._input = InputParser()
        self._period_ns = SECOND
        self._utc_grid = False
        if powered:
            self.power(True)

    def receive(self, data: bytes, time_ns: int) -> None:
        """Bytes from the host, complete at `time_ns`."""
        if not self._running:
            return
        for message in self._input.feed(data):
            if isinstance(message, UbxInput):
                if self._output.in_mask & PROTOCOL_UBX:
                    self._ubx(message)
            elif self._output.in_mask & PROTOCOL_NMEA:
                self._nmea(message)
            if not self._running:
                return

    def _wake(self, off_ns: int) -> None:
        if self._shown is None:
            return
        if self._backup_supply:
            self._next_state = self._engine.restart_state(off_ns)
        else:
            self._settings.lose_battery()
            self._next_state = "cold"

    def _begin(self) -> None:
        """Settings from memory."""
        self._settings.load(sum(cfg.SECTIONS))
        self._engine.start(self._time.now, self._next_state)

    def _start_port(self, epoch: GnssEpoch) -> None:
        self._input.reset()
        self._output.start()
        self._adopt()
        self._shown = self._engine.solve(epoch, self._time.now)

    def _halt(self) -> None:
        self._pulse.stop()
        super()._halt()

    def _adopt(self) -> None:
        """Bring the settings into force that act on navigation and time pulse."""
        self._engine.systems = self._output.style.systems
        self._engine.fix_mode = fix_mode(self._settings)
        self._pulse.net = self.pins["TIMEPULSE"]
        self._pulse.configure(timepulse.decode(self._settings.get(cfg.TP5)))
        measurement_ms, cycles, reference = unpack("<HHH", self._settings.get(cfg.RATE))
        single = len(self._output.style.groups) == 1
        shortest = SHORTEST_PERIOD_SINGLE_MS if single else SHORTEST_PERIOD_MS
        self._period_ns = max(measurement_ms, shortest) * cycles * 1_000_000
        self._utc_grid = reference == TIME_REFERENCE_UTC

    def _epoch_after(self, epoch: GnssEpoch) -> int:
        leap_ns = epoch.leap_seconds * SECOND if self._utc_grid else 0
        nearest_ns = SHORTEST_PERIOD_SINGLE_MS * 500_000
        return self._on_grid(epoch.gps_time_ns - leap_ns, self._period_ns, nearest_ns)

    def _solve(self, epoch: GnssEpoch, now_ns: int) -> Solution:
        solution = self._engine.solve(epoch, now_ns)
        self._engine.latest = solution
        self._pulse.net = self.pins["TIMEPULSE"]
        self._pulse.follow(epoch.gps_time_ns, epoch.leap_seconds, solution.fix > 0)
        return solution

    def _show(self, solution: Solution) -> None:
        self._output.epoch(solution)

    def _ubx(self, message: UbxInput) -> None:
        key = message.message_class << 8 | message.message_id
        if message.message_class == CLASS_CFG:
            self._configure(message.message_id, message.payload)
        elif not message.payload and (key in BINARY or key in SENTENCES):
            self._poll(key)
        else:
            detail = f"ignored, with {len(message.payload)} bytes of payload"
            self._report(ReportKind.NOT_MODELLED, f"UBX 0x{key:04X}", detail)

    def _configure(self, message_id: int, payload: bytes) -> None:
        outcome = self._configurator.handle(message_id, payload)
        answer = acknowledge(outcome.accepted, CLASS_CFG, message_id)
        self._output.frames((*outcome.replies, answer))
        if outcome.restart is not None:
            self._restart(outcome.restart)
        elif outcome.accepted:
            self._settings_changed()

    def _settings_changed(self) -> None:
        """Bring settings into force after an acknowledgement."""
        old = self._period_ns, self._utc_grid, self._engine.systems
        self._output.apply()
        self._adopt()
        if self._engine.systems != old[2] and self._engine.running:
            self._engine.start(self._time.now, self._engine.restart_state(0))
        if (self._period_ns, self._utc_grid) != old[:2] and self._next_epoch is not None:
            self._next_epoch.cancel()
            epoch = self._world.epoch(self._time.now)
            self._next_epoch = self._time.at(self._epoch_after(epoch), self._navigate)

    def _restart(self, restart: Restart) -> None:
        """CFG-RST. A controlled reset waits for the acknowledgement to leave, an immediate one does not."""
        if restart.mode == GNSS_STOP:
            self._engine.stop()
        elif restart.mode in (GNSS_ONLY, GNSS_START):
            self._engine.start(self._time.now, restart.state)
        elif restart.mode == HARDWARE_NOW:
            self._reset_to(restart.state)
        else:
            self._output.transmitter.when_idle(partial(self._reset_to, restart.state))

    def _reset_to(self, state: StartState) -> None:
        self._next_state = state
        self._reset()

    def _nmea(self, message: Sentence) -> None:
        outcome = obey(message.fields, self._settings)
        if outcome.problem is not None:
            self._report(ReportKind.PROTOCOL, message.fields[0], outcome.problem)
        if outcome.not_modelled is not None:
            self._report(ReportKind.NOT_MODELLED, message.fields[0], outcome.not_modelled)
        if outcome.unknown:
            self._output.text(TXT_WARNING, b"NMEA unknown msg")
        elif outcome.poll is not None:
            self._poll(outcome.poll)
        else:
            self._settings_changed()

    def _poll(self, message: int) -> None:
        if self._shown is not None:
            self._output.poll(message, self._shown)
