"""$PSRF commands of a SiRF III (fact sheet section 5, and the numbering of SiRF's public NMEA manual).

| command | fields | what it does here |
| --- | --- | --- |
| 100 | protocol, baud, data bits, stop bits, parity | port; protocol 0 is SiRF binary |
| 101 | X, Y, Z, clock offset, time of week, week, channels, reset | restart, from ECEF |
| 102 | baud, data bits, stop bits, parity | second port, for corrections: none on this board |
| 103 | message, mode, rate, checksum | 0 sets a rate in s, 1 asks once |
| 104 | latitude, longitude, altitude, clock offset, time of week, week, channels, reset | restart |
| 105 | 0 or 1 | development data: reasons of refusal are told |
| 106 | datum | 21 is WGS-84, others are not modelled |
| 107, 108 | | extended ephemeris: not modelled |
"""

from __future__ import annotations

from typing import NamedTuple

BAUD_RATES = (1200, 2400, 4800, 9600, 19_200, 38_400, 57_600, 115_200)
RESETS = {1: "hot", 2: "warm", 3: "warm", 4: "cold", 8: "factory"}
WGS_84 = 21
NUMBER_OF_FIELDS = {100: 5, 101: 8, 102: 4, 103: 4, 104: 8, 105: 1, 106: 1}
NOT_HERE = {102: "a second port for corrections", 107: "extended ephemeris", 108: "extended ephemeris"}
MESSAGES = (0, 1, 2, 3, 4, 5, 6, 8)


class Order(NamedTuple):
    """What a sentence asks for: one of the actions, or what is wrong with it."""

    action: str = ""
    """ "port", "restart", "rate", "query", "development"."""
    values: tuple[int, ...] = ()
    state: str = ""
    """Of a restart."""
    problem: str = ""
    not_modelled: str = ""


def order_of(fields: tuple[str, ...]) -> Order:
    """The order in the comma fields of a sentence with a good checksum, address first."""
    address, arguments = fields[0], fields[1:]
    number = int(address[4:]) if address[:4] == "PSRF" and address[4:].isdecimal() else 0
    if number in NOT_HERE:
        return Order(not_modelled=NOT_HERE[number])
    if number not in NUMBER_OF_FIELDS:
        return Order(problem="unknown sentence: ignored")
    if len(arguments) < NUMBER_OF_FIELDS[number]:
        return Order(problem=f"{len(arguments)} fields instead of {NUMBER_OF_FIELDS[number]}: ignored")
    numbers = [_whole(text) for text in arguments]
    if number in (101, 104):
        reset = numbers[7]
        if reset not in RESETS:
            return Order(problem=f"reset {arguments[7]!r}: ignored")
        return Order("restart", state=RESETS[reset])
    values = tuple(value for value in numbers if value is not None)
    if len(values) < len(numbers):
        return Order(problem=f"a field of {','.join(arguments)} is no number: ignored")
    return {100: _port, 103: _rate, 105: _development, 106: _datum}[number](values)


def _port(values: tuple[int, ...]) -> Order:
    protocol, baud, data_bits, stop_bits, parity = values[:5]
    if protocol not in (0, 1) or baud not in BAUD_RATES:
        return Order(problem=f"protocol {protocol} at {baud} baud: ignored")
    if (data_bits, stop_bits, parity) != (8, 1, 0):
        return Order(not_modelled=f"{data_bits} data bits, {stop_bits} stop bits, parity {parity}")
    return Order("port", (protocol, baud))


def _rate(values: tuple[int, ...]) -> Order:
    message, mode, rate, check = values[:4]
    if message not in MESSAGES or mode not in (0, 1) or not 0 <= rate <= 255 or check not in (0, 1):
        return Order(problem=f"message {message}, mode {mode}, rate {rate}, checksum {check}: ignored")
    if message == 6:
        return Order(not_modelled="MSS, of a beacon receiver")
    return Order("query", (message,)) if mode == 1 else Order("rate", (message, rate, check))


def _development(values: tuple[int, ...]) -> Order:
    if values[0] not in (0, 1):
        return Order(problem=f"development data {values[0]}: ignored")
    return Order("development", values[:1])


def _datum(values: tuple[int, ...]) -> Order:
    return Order() if values[0] == WGS_84 else Order(not_modelled=f"datum {values[0]}")


def _whole(text: str) -> int | None:
    return int(text) if text.isdecimal() and len(text) < 10 else None
