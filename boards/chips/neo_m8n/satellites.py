"""Satellites in sentences: GSA and GSV (fact sheet section 2).

GSV shows elevation (0–90), azimuth (0–359) and C/N0 (0–99, empty when not tracked) in whole units; the
last sentence has only as many blocks as satellites are left. GSA has twelve slots; without a fix it is
empty with all dilutions 99.99.

Printing 23 satellites takes half the time of an epoch of the default set, and satellites move slowly: the
sentences are kept for as long as the solutions hold the very same satellites and dilutions.
"""

from __future__ import annotations

import math
from functools import cached_property

from boards.chips.neo_m8n.solution import Solution
from boards.chips.neo_m8n.style import SYSTEM_ID, VERSION_4_1, NmeaStyle
from boards.chips.receivers.fields import dilution, sentence

GSA_SLOTS = 12
GSV_BLOCKS = 4
_DEGREES = 180.0 / math.pi
_TWO_DIGITS = [b",%02d" % value for value in range(100)]
_THREE_DIGITS = [b",%03d" % (value % 360) for value in range(361)]


class Sky:
    """The satellites of one solution, printed once and shared by GSA, GSV and GNS."""

    def __init__(self, solution: Solution, style: NmeaStyle) -> None:
        self._solution = solution
        self._style = style
        self._seen: dict[bytes, list[bytes]] = {group: [] for group in style.groups}
        self._used: dict[bytes, list[bytes]] = {group: [] for group in style.groups}
        seen = {system: self._seen[group].append for system, group in style.listed.items()}
        numbers = style.numbers
        sky_known = solution.sky_known
        fix = solution.fix
        for satellite in solution.satellites:
            system = satellite.system
            if system not in seen:
                continue
            number = numbers[system, satellite.number]
            cn0 = int(satellite.cn0_dbhz + 0.5)
            level = _TWO_DIGITS[cn0 if cn0 < 99 else 99] if cn0 > 0 else b","
            if sky_known:
                elevation = int(satellite.elevation * _DEGREES + 0.5)
                azimuth = int(satellite.azimuth * _DEGREES % 360.0 + 0.5)
                elevation = 0 if elevation < 0 else 90 if elevation > 90 else elevation
                seen[system](number + _TWO_DIGITS[elevation] + _THREE_DIGITS[azimuth] + level)
            else:
                seen[system](number + b",," + level)
            if fix and satellite.used:
                self._used[style.listed[system]].append(number)

    def shows(self, solution: Solution, style: NmeaStyle) -> bool:
        """Whether it is also the sky of this solution, written in this style."""
        mine = self._solution
        now, then = solution.epoch, mine.epoch
        return (
            solution.satellites is mine.satellites
            and solution.fix == mine.fix
            and solution.sky_known == mine.sky_known
            and (now.pdop, now.hdop, now.vdop) == (then.pdop, then.hdop, then.vdop)
            and style is self._style
        )

    def has_used(self, group: bytes) -> bool:
        """Whether a satellite of the group is used."""
        return bool(self._used.get(group))

    @cached_property
    def gsa(self) -> list[bytes]:
        """One GSA for each enabled system."""
        style = self._style
        fix = self._solution.fix
        epoch = self._solution.epoch
        if fix:
            dops = b"%b,%b,%b" % (dilution(epoch.pdop), dilution(epoch.hdop), dilution(epoch.vdop))
        else:
            dops = b"99.99,99.99,99.99"
        head = b"%bGSA,%b,%d" % (style.talker, b"M" if style.manual_mode else b"A", fix or 1)
        printed = []
        for group, numbers in self._used.items():
            slots = numbers[:GSA_SLOTS]
            body = b"%b%b%b,%b" % (head, b"".join(slots), b"," * (GSA_SLOTS - len(slots)), dops)
            if style.version >= VERSION_4_1:
                body += b",%d" % SYSTEM_ID[group]
            printed.append(sentence(body))
        return printed

    @cached_property
    def gsv(self) -> list[bytes]:
        """The GSV sentences of each enabled system; one without blocks when nothing is in view."""
        style = self._style
        signal = b",0" if style.version >= VERSION_4_1 else b""
        printed = []
        for group, all_blocks in self._seen.items():
            blocks = all_blocks[: style.most_satellites] if style.most_satellites else all_blocks
            count = len(blocks)
            messages = (count + GSV_BLOCKS - 1) // GSV_BLOCKS or 1
            name = style.talker if style.gsv_by_main_talker else style.group_talker(group)
            for message in range(messages):
                shown = b"".join(blocks[message * GSV_BLOCKS : (message + 1) * GSV_BLOCKS])
                body = b"%bGSV,%d,%d,%02d%b%b" % (name, messages, message + 1, count, shown, signal)
                printed.append(sentence(body))
        return printed


class PrintedSkies:
    """Remembers the sky printed last."""

    def __init__(self) -> None:
        self._last: Sky | None = None

    def of(self, solution: Solution, style: NmeaStyle) -> Sky:
        """The sky of a solution."""
        sky = self._last
        if sky is None or not sky.shows(solution, style):
            self._last = sky = Sky(solution, style)
        return sky
