"""What this board tells in words beside what all do; trouble when it begins and when it is over."""

from __future__ import annotations

from firmware.apps.gfsins.acquisition_news import AcquisitionNews
from firmware.apps.gfsins.navigation import Navigation
from firmware.apps.gfsins.reception import Reception
from firmware.apps.gnss_ins.output import Output
from firmware.nav.gyro_free import layout as gl

SILENT_LOOKS = 3
"""Looks (10 a second) without a packet after which the acquisition is called silent."""
AGAIN_LOOKS = 100
SYNC_LOOKS = 5
FILTERS = ("compass", "GPS")
CHIPS = 7


class Words:
    """Looks ten times a second, from the background."""

    def __init__(
        self, navigation: Navigation, reception: Reception, news: AcquisitionNews, output: Output
    ) -> None:
        self._navigation = navigation
        self._reception = reception
        self._news = news
        self._output = output
        self._good = 0
        self._quiet = 0
        self._restarts = 0
        self._bad = 0
        self._lost = 0
        self._looks = 0
        self._said_look = -AGAIN_LOOKS
        self._status = [0, 0]
        self._missing = self._stuck = self._at_odds = self._compass = 0
        self._synced = True
        self._sync_looks = 0
        self._answers = True
        self._in_settings = False

    @property
    def is_silent(self) -> bool:
        """Whether no packets come."""
        return self._quiet >= SILENT_LOOKS

    def look(self) -> None:
        """Say what is new."""
        self._looks += 1
        self._look_at_packets()
        self._look_at_sync()
        self._look_at_filters()
        self._look_at_status()

    def _look_at_packets(self) -> None:
        reception, say = self._reception, self._output.send_text
        before = self._quiet
        self._quiet = before + 1 if reception.good == self._good else 0
        if self._quiet == SILENT_LOOKS and self._good:
            say("acquisition silent: no packets")
        elif before >= SILENT_LOOKS and not self._quiet and self._good:
            say("acquisition is back")
        self._good = reception.good
        if reception.restarts != self._restarts:
            self._restarts = reception.restarts
            say("acquisition restarted")
        bad, lost = sum(reception.bad), reception.lost
        if (bad > self._bad or lost > self._lost) and self._looks - self._said_look >= AGAIN_LOOKS:
            self._said_look = self._looks
            self._bad, self._lost = bad, lost
            _, slipped, kind, wrong = reception.bad
            say(f"packets: {lost} lost, {slipped} slipped, {kind} of a wrong kind, {wrong} with a wrong sum")

    def _look_at_sync(self) -> None:
        """Told when it has been so for SYNC_LOOKS while packets came."""
        differs = self._reception.synced != self._synced and not self._quiet
        self._sync_looks = self._sync_looks + 1 if differs else 0
        if self._sync_looks >= SYNC_LOOKS:
            self._sync_looks = 0
            self._synced = not self._synced
            told = "sync line is back" if self._synced else "sync line lost: ticks are dated by their packets"
            self._output.send_text(told)

    def _look_at_filters(self) -> None:
        n = self._navigation.federation.n
        for k, name in enumerate(FILTERS):
            status = int(n[gl.STATUS + k])
            if status != self._status[k]:
                self._status[k] = status
                cause = gl.CAUSE_NAMES[int(n[gl.ISOLATED_BY + k])]
                told = f"isolated: {cause}" if status == gl.ISOLATED else "trusted again"
                self._output.send_text(f"{name} filter {told}")

    def _look_at_status(self) -> None:
        news, say = self._news, self._output.send_text
        if news.answers != self._answers:
            self._answers = news.answers
            say("acquisition answers commands again" if news.answers else "acquisition answers no command")
        if news.in_settings != self._in_settings:
            self._in_settings = news.in_settings
            now = "is in" if news.in_settings else "has left"
            say(f"acquisition {now} settings mode")
        self._missing = self._tell_chips(news.missing, self._missing, "missing")
        self._stuck = self._tell_chips(news.stuck, self._stuck, "stuck")
        self._at_odds = self._tell_chips(news.at_odds, self._at_odds, "at odds with the others")
        if news.compass != self._compass:
            self._compass = news.compass
            say(f"compass: {news.compass_words}")

    def _tell_chips(self, now: int, before: int, trouble: str) -> int:
        for chip in range(CHIPS):
            if (now ^ before) >> chip & 1:
                told = trouble if now >> chip & 1 else f"no longer {trouble}"
                self._output.send_text(f"accelerometer {chip + 1} {told}")
        return now
