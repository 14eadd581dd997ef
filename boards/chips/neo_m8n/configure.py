"""What CFG messages do (fact sheet section 4).

An empty payload (or one that only selects) is a poll: the setting is sent, then ACK-ACK. A write is
answered with ACK-ACK, or with ACK-NAK when it is malformed, out of range, or asks for something that this
model has not; the latter leaves a report.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from struct import unpack

from boards.chips.neo_m8n import settings as cfg
from boards.chips.neo_m8n import timepulse
from boards.chips.neo_m8n.catalogue import BINARY, EVENT_DRIVEN, MISSING, SENTENCES
from boards.chips.neo_m8n.configure_systems import (
    gnss_problem,
    gnss_update,
    nav5_update,
    nmea_problem,
    nmea_update,
)
from boards.chips.neo_m8n.engine import StartState
from boards.chips.neo_m8n.settings import Settings
from boards.chips.neo_m8n.ubx import CLASS_CFG, frame
from boards.chips.registers import ReportKind

NOT_MODELLED, PROTOCOL = ReportKind.NOT_MODELLED, ReportKind.PROTOCOL

LOWEST_BAUD, HIGHEST_BAUD = 4800, 921_600
FRAME_FORMAT_MASK = 0x3EC0
"""Character length, parity and stop bits within the mode field."""

RST = 0x04
CFG = 0x09
HARDWARE_NOW, SOFTWARE, GNSS_ONLY, HARDWARE, GNSS_STOP, GNSS_START = 0, 1, 2, 4, 8, 9
RESET_MODES = (HARDWARE_NOW, SOFTWARE, GNSS_ONLY, HARDWARE, GNSS_STOP, GNSS_START)
EPHEMERIS = 0x0001


@dataclass(frozen=True, slots=True)
class Restart:
    """A CFG-RST that was accepted."""

    mode: int
    state: StartState


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a message led to: ACK or NAK, messages to send before it, a restart after it."""

    accepted: bool
    replies: tuple[bytes, ...] = ()
    restart: Restart | None = None


REFUSED = Outcome(False)
DONE = Outcome(True)


Report = Callable[[ReportKind, str, str], None]


class Configurator:
    """Reads and writes the settings on behalf of the host at UART1.

    `report(kind, setting, detail)` hears of what the model leaves out and of what is out of order.
    """

    def __init__(self, settings: Settings, report: Report) -> None:
        self._settings = settings
        self._report = report
        self._handlers: dict[int, Callable[[bytes], Outcome]] = {
            cfg.PRT: self._ports,
            cfg.MSG: self._message_rate,
            cfg.INF: self._texts,
            RST: self._reset,
            cfg.RATE: self._navigation_rate,
            CFG: self._memories,
            cfg.NMEA: self._nmea,
            cfg.NAV5: self._navigation_model,
            cfg.TP5: self._time_pulse,
            cfg.GNSS: self._systems,
        }

    def handle(self, message_id: int, payload: bytes) -> Outcome:
        """Work on one CFG message."""
        handler = self._handlers.get(message_id)
        if handler is None:
            self._report(
                NOT_MODELLED, f"CFG 0x{message_id:02X}", "this configuration message is not modelled"
            )
            return REFUSED
        return handler(payload)

    def _answer(self, message_id: int, selector: int = 0) -> Outcome:
        payload = self._settings.get(message_id, selector)
        return Outcome(True, (frame(CLASS_CFG, message_id, payload),))

    def _ports(self, payload: bytes) -> Outcome:
        if len(payload) <= 1:
            port = payload[0] if payload else cfg.UART1
            return self._answer(cfg.PRT, port) if port in cfg.PORTS else REFUSED
        size = cfg.PORT_LAYOUT.size
        blocks = [payload[start : start + size] for start in range(0, len(payload), size)]
        if not all(len(block) == size and self._port_is_good(block) for block in blocks):
            return REFUSED
        for block in blocks:
            self._settings.set(cfg.PRT, block[0], block)
        return DONE

    def _port_is_good(self, block: bytes) -> bool:
        port, _, tx_ready, mode, baud, *_ = cfg.PORT_LAYOUT.unpack(block)
        if port not in cfg.PORTS:
            return False
        if port != cfg.UART1:
            return True
        if mode & FRAME_FORMAT_MASK != cfg.MODE_8N1 & FRAME_FORMAT_MASK:
            self._report(
                NOT_MODELLED, "CFG-PRT", f"frame format of mode 0x{mode:04X}: only 8N1 (0x08D0) is modelled"
            )
            return False
        if tx_ready & 1:
            self._report(NOT_MODELLED, "CFG-PRT", "the TX-ready pin is not modelled")
        return LOWEST_BAUD <= baud <= HIGHEST_BAUD

    def _message_rate(self, payload: bytes) -> Outcome:
        if len(payload) not in (2, 3, 8):
            return REFUSED
        message = payload[0] << 8 | payload[1]
        known = message in BINARY or message in SENTENCES or message in EVENT_DRIVEN
        if not known and message not in MISSING:
            self._report(PROTOCOL, "CFG-MSG", f"0x{message:04X} is no message of this receiver")
            return REFUSED
        rates = bytearray(self._settings.rates(message))
        if len(payload) == 2:
            return Outcome(True, (frame(CLASS_CFG, cfg.MSG, payload + rates),))
        if len(payload) == 3:
            rates[cfg.UART1] = payload[2]
        else:
            rates = bytearray(payload[2:])
        if not known and rates[cfg.UART1]:
            self._report(NOT_MODELLED, "CFG-MSG", f"message 0x{message:04X} is not modelled")
            return REFUSED
        self._settings.set(cfg.MSG, message, bytes(rates))
        return DONE

    def _texts(self, payload: bytes) -> Outcome:
        if len(payload) == 1:
            return self._answer(cfg.INF, payload[0]) if payload[0] in (0, 1) else REFUSED
        blocks = [payload[start : start + 10] for start in range(0, len(payload), 10)]
        if not blocks or not all(len(block) == 10 and block[0] in (0, 1) for block in blocks):
            return REFUSED
        for block in blocks:
            self._settings.set(cfg.INF, block[0], block)
        return DONE

    def _reset(self, payload: bytes) -> Outcome:
        if len(payload) != 4 or payload[2] not in RESET_MODES:
            return REFUSED
        lost = payload[0] | payload[1] << 8
        state: StartState = "cold" if lost & ~EPHEMERIS else "warm" if lost else "hot"
        return Outcome(True, restart=Restart(payload[2], state))

    def _navigation_rate(self, payload: bytes) -> Outcome:
        if not payload:
            return self._answer(cfg.RATE)
        if len(payload) != 6:
            return REFUSED
        period_ms, cycles, reference = unpack("<HHH", payload)
        if period_ms < 25 or not 1 <= cycles <= 127 or reference > 4:
            return REFUSED
        self._settings.set(cfg.RATE, 0, payload)
        return DONE

    def _memories(self, payload: bytes) -> Outcome:
        if len(payload) not in (12, 13):
            return REFUSED
        clear, save, load = unpack("<III", payload[:12])
        devices = payload[12] if len(payload) == 13 else sum(cfg.DEVICES)
        self._settings.clear(clear, devices)
        self._settings.save(save, devices)
        self._settings.load(load)
        return DONE

    def _nmea(self, payload: bytes) -> Outcome:
        if not payload:
            return self._answer(cfg.NMEA)
        updated = nmea_update(self._settings.get(cfg.NMEA), payload)
        if updated is None:
            return REFUSED
        problem = nmea_problem(updated)
        if problem is not None:
            self._report(NOT_MODELLED if "not modelled" in problem else PROTOCOL, "CFG-NMEA", problem)
            return REFUSED
        self._settings.set(cfg.NMEA, 0, updated)
        return DONE

    def _navigation_model(self, payload: bytes) -> Outcome:
        if not payload:
            return self._answer(cfg.NAV5)
        updated = nav5_update(self._settings.get(cfg.NAV5), payload)
        if updated is None:
            return REFUSED
        if updated[4:] != cfg.DEFAULTS[cfg.NAV5, 0][4:]:
            self._report(
                NOT_MODELLED,
                "CFG-NAV5",
                "masks, static hold and fixed altitude are stored but have no effect",
            )
        self._settings.set(cfg.NAV5, 0, updated)
        return DONE

    def _time_pulse(self, payload: bytes) -> Outcome:
        if len(payload) <= 1:
            return REFUSED if payload and payload[0] else self._answer(cfg.TP5)
        if len(payload) != timepulse.LAYOUT.size or payload[0]:
            return REFUSED
        wanted = timepulse.decode(payload)
        for pulse in (wanted.unlocked, wanted.locked):
            if wanted.active and pulse.length_ns and pulse.period_ns < timepulse.SHORTEST_PERIOD_NS:
                self._report(NOT_MODELLED, "CFG-TP5", "periods below 1 ms are not modelled")
                return REFUSED
            if pulse.length_ns > pulse.period_ns:
                return REFUSED
        self._settings.set(cfg.TP5, 0, payload)
        return DONE

    def _systems(self, payload: bytes) -> Outcome:
        if not payload:
            return self._answer(cfg.GNSS)
        updated = gnss_update(self._settings.get(cfg.GNSS), payload)
        if updated is None:
            return REFUSED
        problem = gnss_problem(updated)
        if problem is not None:
            self._report(PROTOCOL, "CFG-GNSS", problem)
            return REFUSED
        self._settings.set(cfg.GNSS, 0, updated)
        return DONE
