"""The program of the FPGA's processor: sensors at 200 Hz, a packet for each tick to the DSP.

acquisition   timer: seven FIFOs, scale and offset, packet, DMA to the DSP
gnss_receive  the receiver's sentences, by DMA into memory
command       what the DSP writes over I²C
main          compass and set-up of the receiver, chips that went missing, watchdog
"""

from __future__ import annotations

from typing import Final

import numpy as np

from firmware.apps.gfsins import commands
from firmware.apps.gfsins.accelerations import CHIPS
from firmware.apps.gfsins.accelerometers import ALL, Accelerometers
from firmware.apps.gfsins.agreement import Agreement
from firmware.apps.gfsins.calibration import Calibration
from firmware.apps.gfsins.coefficients import FIRST_WORD, WORDS
from firmware.apps.gfsins.compass_line import CompassLine
from firmware.apps.gfsins.filled_packet import fill_packet
from firmware.apps.gfsins.packet_words import put_compass, put_epoch
from firmware.apps.gfsins.receiver_line import ReceiverLine
from firmware.apps.gfsins.settings import TICKS_PER_S
from firmware.drivers.hmc6343 import Outcome as CompassOutcome
from firmware.nav.gyro_free import packet as pk
from firmware.numerics.dialect import entry_point
from hal.board_io import BoardIo
from hal.machine_code import mypyc_attr

LOOKS_PER_S: Final = 10
TICKS_PER_LOOK: Final = TICKS_PER_S // LOOKS_PER_S
WATCHDOG_NS: Final = 4_000_000_000
COMPASS_OUTCOMES: Final = tuple(CompassOutcome)


@mypyc_attr(allow_interpreted_subclasses=True)
class Acquisition:
    """Implements `hal.board_io.Program`."""

    def __init__(self, io: BoardIo, calibration: Calibration) -> None:
        self._io = io
        self._calibration = calibration
        self._scales, self._offsets = calibration.corrections.scales, calibration.corrections.offsets
        self._fill = entry_point(fill_packet)
        self._starts = 0
        """Kept over resets in a register of the FPGA that a reset of the processor leaves alone."""

    def main(self) -> None:
        """From the reset vector."""
        io = self._io
        self._starts = self._starts + 1 & commands.BYTE
        self._ticks = 0
        self._sequence = 0
        self._words = np.zeros(pk.WORDS, np.int64)
        self._data = np.zeros(pk.BYTES, np.uint8)
        self._chips = Accelerometers(io)
        self._raw = np.frombuffer(self._chips.raw, np.uint8)
        self._agreement = Agreement(self._raw)
        self._compass = CompassLine(io)
        self._receiver = ReceiverLine(io)
        self._sender = io.packet_senders["packets"]
        self._dropped = 0
        self._coefficients = self._calibration.packet_words()
        self._sync = io.outputs["sync"]
        self._slave = io.i2c_slaves["commands"]
        self._clock, self._cpu = io.clock, io.cpu
        self._tick_cost = io.cpu.cost("tick")
        self._look_cost = io.cpu.cost("health")
        self._slave.begin(io.interrupts.attach("command", self._on_command))
        line = io.interrupts.attach("acquisition", self._on_tick)
        io.watchdog.start(WATCHDOG_NS)
        for chip in range(CHIPS):
            self._chips.start(chip)
        self._receiver.listen()
        io.timers["acquisition"].start(TICKS_PER_S, line)
        self._compass.start()
        self._work()

    def _work(self) -> None:
        """The background, for ever: ten times a second."""
        io = self._io
        done = 0
        while True:
            while self._ticks // TICKS_PER_LOOK == done:
                io.cpu.wait_for_interrupt()
            done = self._ticks // TICKS_PER_LOOK
            io.watchdog.kick()
            self._compass.look()
            self._receiver.service()
            chips = self._chips
            chips.at_odds = self._agreement.look(ALL & ~(chips.missing | chips.stuck))
            if done % LOOKS_PER_S == 0:
                self._mend()
            io.cpu.spend(self._look_cost)
            self._slave.answer(self._status())

    def _mend(self) -> None:
        """Bring up one chip that is missing."""
        for chip in range(CHIPS):
            if self._chips.missing >> chip & 1:
                self._chips.start(chip)

    def _status(self) -> bytes:
        chips, receiver = self._chips, self._receiver
        return commands.pack_status(
            commands.MARK,
            self._starts,
            chips.missing,
            chips.stuck,
            chips.at_odds,
            COMPASS_OUTCOMES.index(self._compass.outcome),
            receiver.phase,
            receiver.port_errors & commands.BYTE,
            self._dropped & 0xFFFF,
        )

    def _on_command(self) -> None:
        command = self._slave.taken()
        if command and command[0] == commands.ALIGNED:
            self._io.outputs["led"].set(True)

    def _on_tick(self) -> None:
        """A packet."""
        sync = self._sync
        sync.set(True)
        tick_ns = self._clock.now_ns()
        self._ticks += 1
        chips, words = self._chips, self._words
        chips.drain()
        flags = 0
        reading = self._compass.take()
        if reading is not None:
            flags = put_compass(words, reading, tick_ns)
        if self._receiver.is_fresh:
            self._receiver.is_fresh = False
            flags |= put_epoch(words, self._receiver.waiting.tolist(), tick_ns)
        sequence, data = self._sequence, self._data
        told = self._coefficients
        if told is not None:
            words[FIRST_WORD : FIRST_WORD + WORDS] = told[sequence % len(told)]
        faults = chips.missing | chips.stuck | chips.at_odds
        tick_us = tick_ns // 1000
        self._fill(
            self._raw, self._scales, self._offsets, words, data, sequence, tick_us, chips.fresh, faults, flags
        )
        self._sequence = sequence + 1 & 0xFFFF
        self._cpu.spend(self._tick_cost)
        self._dropped += not self._sender.send(data.tobytes())
        sync.set(False)

    def spoil(self) -> None:
        """There is no navigation here."""

    def memory(self) -> bytes:
        """Nothing that navigation depends on outlives its handing over."""
        return b""
