"""Standard sentences of one epoch (fact sheet section 2): RMC VTG GGA GNS GLL GST ZDA and TXT.

Methods that print one sentence give its body, without "$", checksum and line end (`fields.sentence` adds
them); GSA and GSV come whole from `satellites`, where they are kept from epoch to epoch. Field widths and
precisions are those of real M8N logs. Without a fix the forms of the table "no-fix output" appear; the time
fields fill as soon as the time is known. NMEA 2.1 has no posMode, 4.1 adds the navigation status ("V": this
equipment gives none).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

from boards.chips.neo_m8n.satellites import Sky
from boards.chips.neo_m8n.solution import Solution
from boards.chips.neo_m8n.style import VERSION_2_3, VERSION_4_1, NmeaStyle
from boards.chips.receivers.fields import course, decimal, dilution, position, two_figures

KNOTS = 3600.0 / 1852.0
KILOMETRES_PER_HOUR = 3.6
MOST_USED_SHOWN = 12
"""GGA counts no more satellites than GSA has slots for."""

TXT_ERROR = 0
TXT_WARNING = 1
TXT_NOTICE = 2


class NmeaSet:
    """Prints one solution. Fields that several sentences share are made once, when the first wants them.

    `sky_of` gives the printed satellites of a solution.
    """

    def __init__(
        self, solution: Solution, style: NmeaStyle, sky_of: Callable[[Solution, NmeaStyle], Sky] = Sky
    ) -> None:
        self.solution = solution
        self.style = style
        self.talker = style.talker
        self._sky_of = sky_of

    @cached_property
    def time(self) -> bytes:
        """Time of day, empty until it is known."""
        utc = self.solution.utc
        if not self.solution.time_known:
            return b""
        return b"%02d%02d%02d.%02d" % (utc.hour, utc.minute, utc.second, utc.centisecond)

    @cached_property
    def date(self) -> bytes:
        """Day, month, year of the century; empty until it is known."""
        utc = self.solution.utc
        if not self.solution.time_known:
            return b""
        return b"%02d%02d%02d" % (utc.day, utc.month, utc.year % 100)

    @cached_property
    def position(self) -> bytes:
        """The four fields of latitude and longitude."""
        solution, style = self.solution, self.style
        if solution.fix or (style.show_invalid_position and solution.position_known):
            return position(solution.latitude_deg, solution.longitude_deg, style.fine)
        return b",,,"

    @cached_property
    def course(self) -> bytes:
        """Course over ground, empty where it does not count."""
        solution = self.solution
        shown = solution.fix and (solution.course_valid or self.style.show_frozen_course)
        return course(solution.course_deg) if shown else b""

    @cached_property
    def sky(self) -> Sky:
        """The printed satellites."""
        return self._sky_of(self.solution, self.style)

    @cached_property
    def _mode_tail(self) -> bytes:
        if self.style.version < VERSION_2_3:
            return b""
        return b",A" if self.solution.fix else b",N"

    def rmc(self) -> bytes:
        """Recommended minimum: time, status, position, speed, course, date."""
        solution = self.solution
        tail = self._mode_tail + b",V" if self.style.version >= VERSION_4_1 else self._mode_tail
        status, knots = (b"A", b"%.3f" % (solution.speed * KNOTS)) if solution.fix else (b"V", b"")
        return b"%bRMC,%b,%b,%b,%b,%b,%b,,%b" % (
            self.talker,
            self.time,
            status,
            self.position,
            knots,
            self.course,
            self.date,
            tail,
        )

    def vtg(self) -> bytes:
        """Course and speed."""
        solution = self.solution
        if not solution.fix:
            return b"%bVTG,,,,,,,,%b" % (self.talker, self._mode_tail)
        speed = solution.speed
        return b"%bVTG,%b,T,,M,%.3f,N,%.3f,K%b" % (
            self.talker,
            self.course,
            speed * KNOTS,
            speed * KILOMETRES_PER_HOUR,
            self._mode_tail,
        )

    def gga(self) -> bytes:
        """Fix data with altitude."""
        solution = self.solution
        head = b"%bGGA,%b,%b" % (self.talker, self.time, self.position)
        if not solution.fix:
            return head + b",0,00,99.99,,,,,,"
        used = min(solution.used, MOST_USED_SHOWN)
        altitude, separation = self._heights()
        return b"%b,1,%02d,%b,%b,M,%b,M,," % (head, used, dilution(solution.epoch.hdop), altitude, separation)

    def gns(self) -> bytes:
        """Fix data with one mode letter for each system; as many letters as the version knows systems."""
        solution = self.solution
        letters = b"".join(b"A" if self._group_used(group) else b"N" for group in (b"GP", b"GL"))
        tail = b""
        if self.style.version >= VERSION_4_1:
            letters += b"".join(b"A" if self._group_used(group) else b"N" for group in (b"GA", b"GB"))
            tail = b",V"
        head = b"%bGNS,%b,%b,%b" % (self.talker, self.time, self.position, letters)
        if not solution.fix:
            return head + b",00,99.99,,,," + tail
        altitude, separation = self._heights()
        hdop = dilution(solution.epoch.hdop)
        return b"%b,%02d,%b,%b,%b,,%b" % (head, solution.used, hdop, altitude, separation, tail)

    def gll(self) -> bytes:
        """Position and time."""
        status = b"A" if self.solution.fix else b"V"
        head = b"%bGLL,%b,%b" % (self.talker, self.position, self.time)
        return b"%b,%b%b" % (head, status, self._mode_tail)

    def gst(self) -> bytes:
        """Error statistics; the error ellipse stays empty, as on the real receiver."""
        epoch = self.solution.epoch
        if not self.solution.fix:
            return b"%bGST,%b,,,,,,," % (self.talker, self.time)
        level, up = two_figures(epoch.h_acc * 0.5**0.5), two_figures(epoch.v_acc)
        ranges = two_figures(epoch.h_acc / max(epoch.hdop, 0.01))
        return b"%bGST,%b,%b,,,,%b,%b,%b" % (self.talker, self.time, ranges, level, level, up)

    def zda(self) -> bytes:
        """Time and date."""
        if not self.solution.time_known:
            return b"%bZDA,,,,,00,00" % self.talker
        utc = self.solution.utc
        day = b"%02d,%02d,%04d" % (utc.day, utc.month, utc.year)
        return b"%bZDA,%b,%b,00,00" % (self.talker, self.time, day)

    def _group_used(self, group: bytes) -> bool:
        return bool(self.solution.fix) and self.sky.has_used(group)

    def _heights(self) -> tuple[bytes, bytes]:
        solution = self.solution
        digits = 3 if self.style.fine else 1
        altitude = decimal(solution.height - solution.separation, digits)
        return altitude, decimal(solution.separation, digits)


def txt(talker: bytes, kind: int, text: bytes) -> bytes:
    """Body of a one-sentence text message of kind 0 error, 1 warning, 2 notice."""
    return b"%bTXT,01,01,%02d,%b" % (talker, kind, text)
