"""A compass driver as others write it: says a command until it is accepted, reads several attitude sentences.

It rests on the fact sheet's section 6 for the sentences, and on the three commands of the page on this part.
"""

from __future__ import annotations

from dataclasses import replace
from functools import reduce
from operator import xor

import pytest
from test_dual_antenna import ALL, BASELINE, EPOCH, Rig

HEADING, PITCH = 123.456, -1.234


class Driver:
    """Sends one byte after the other and keeps the sentences whose sums are right."""

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        self.heard: list[list[str]] = []
        self.bad = 0

    def send(self, text: str) -> int:
        """How often it had to be said until "$>" came."""
        for attempt in range(1, 5):
            for byte in text.encode() + b"\r\n":
                self.rig.chip.receive(bytes((byte,)), self.rig.time.now)
            if any(line.endswith("$>") for line in self.listen(0.3)):
                return attempt
        raise TimeoutError(text)

    def listen(self, seconds: float) -> list[str]:
        lines = self.rig.wait(seconds)
        for line in lines:
            start, star = line.rfind("$"), line.find("*")
            if star < 0:
                continue
            body, digits = line[start + 1 : star], line[star + 1 :]
            if int(digits, 16) == reduce(xor, body.encode(), 0):
                self.heard.append(body.split(","))
            else:
                self.bad += 1
        return lines


def heading_of(fields: list[str]) -> float | None:
    """Of the sentences that it knows; None where there is none, or none that may be believed."""
    name = (
        ",".join(fields[:2])
        if fields[1:2] == ["HPR"]
        else fields[0][2:]
        if fields[0][:2] == "GP"
        else fields[0]
    )
    place = {"HDT": 1, "THS": 1, "PASHR": 2, "PASHR,HPR": 3, "PSAT,HPR": 3, "HPR": 2}.get(name)
    if place is None or not fields[place]:
        return None
    believed = {
        "THS": lambda: fields[2] == "A",
        "PASHR": lambda: fields[10] != "0",
        "PASHR,HPR": lambda: fields[7] == "0",
        "HPR": lambda: fields[5] == "4",
    }.get(name, lambda: True)
    return float(fields[place]) if believed() else None


def test_set_up_step_by_step_and_read_every_sentence() -> None:
    driver = Driver(Rig(rate_hz=10, sentences=ALL, baud=115_200))
    driver.rig.wait(13.0)
    assert driver.send("$JOFF") == 1
    for name in ("GPGGA,1", "GPHDT,10", "GPTHS,5,OTHER", "PASHR,5", "PSAT,HPR,1,OTHER", "GPHPR,1"):
        assert driver.send(f"$JASC,{name}") == 1
    driver.listen(1.0)
    driver.heard.clear()
    driver.listen(4.0)
    assert driver.bad == 0
    counts = [
        sum(fields[0] == name for fields in driver.heard) for name in ("GPGGA", "GPHDT", "GPTHS", "PASHR")
    ]
    assert counts == [4, 40, 20, 20]
    headings = [heading_of(fields) for fields in driver.heard if fields[0] != "GPGGA"]
    assert headings == [HEADING] * (40 + 20 + 20 + 4 + 4)
    pashr = next(fields for fields in driver.heard if fields[0] == "PASHR")
    assert (pashr[3], float(pashr[5]), pashr[4]) == ("T", PITCH, "")
    assert driver.rig.chip.reports == []


@pytest.mark.parametrize("baseline", [None, "FLOAT"])
def test_it_believes_no_heading_that_there_is_not(baseline: str | None) -> None:
    """Without second antenna, or with ambiguities that are no whole numbers."""
    told = None if baseline is None else replace(BASELINE, fix="FLOAT")
    driver = Driver(Rig(replace(EPOCH, baseline=told), sentences=["HDT", "THS", "PASHR,HPR", "HPR"]))
    driver.rig.wait(14.0)
    driver.listen(3.0)
    assert len(driver.heard) == 12
    assert [heading_of(fields) for fields in driver.heard] == [None] * 12


def test_a_command_with_a_byte_lost_is_said_again() -> None:
    driver = Driver(Rig())
    driver.rig.wait(2.0)
    driver.rig.chip.receive(b"$JASC,GPZ", driver.rig.time.now)
    assert driver.send("$JASC,GPZDA,1") == 1
    with pytest.raises(TimeoutError):
        driver.send("$JASC,GPXYZ,1")


def test_a_checksum_need_not_be_there_but_must_be_right() -> None:
    driver = Driver(Rig())
    driver.rig.wait(2.0)
    total = reduce(xor, b"JASC,GPZDA,1", 0)
    assert driver.send(f"$JASC,GPZDA,1*{total:02x}") == 1
    with pytest.raises(TimeoutError):
        driver.send(f"$JOFF*{reduce(xor, b'JOFF', 0) ^ 1:02X}")
    assert {report.kind.value for report in driver.rig.chip.reports} == {"protocol"}
    driver.heard.clear()
    driver.listen(2.0)
    assert any(fields[0] == "GPZDA" for fields in driver.heard)
