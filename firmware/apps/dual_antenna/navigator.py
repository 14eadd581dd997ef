"""The program of the DSP: strapdown at 200 Hz, filter at each epoch, what the host is told.

navigation (mailbox) ─► output
                     └► filter                   main: health, words, watchdog
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from firmware.apps.dual_antenna.exchange import Exchange
from firmware.apps.dual_antenna.front_end_news import FrontEndNews
from firmware.apps.dual_antenna.host_port import HostPort
from firmware.apps.dual_antenna.memory_map import check_memory
from firmware.apps.dual_antenna.navigation import Navigation, NavigationKernels, nav_config
from firmware.apps.dual_antenna.paced_output import PacedOutput
from firmware.apps.dual_antenna.settings import Settings
from firmware.apps.dual_antenna.words import Words
from firmware.apps.gnss_ins.announcements import Announcer
from hal.board_io import BoardIo

RATE_HZ = 10
WATCHDOG_NS = 2_000_000_000


def program(io: BoardIo, profile: Mapping[str, Any], installation: Mapping[str, Any]) -> Navigator:
    """The image in flash. Raises ValueError for a profile that no program could mean."""
    return Navigator(io, Settings.of(profile), installation)


class Navigator:
    """Implements `hal.board_io.Program`."""

    def __init__(self, io: BoardIo, settings: Settings, installation: Mapping[str, Any]) -> None:
        check_memory(io.memories["exchange"])
        self._io = io
        self._settings = settings
        self._kernels = NavigationKernels(settings.precision)
        self._config = nav_config(settings, installation)
        self._navigation: Navigation | None = None

    def main(self) -> None:
        """From the reset vector: nothing survives a reset."""
        io, settings = self._io, self._settings
        navigation = Navigation(self._kernels, self._config, settings.attitude)
        self._navigation = navigation
        exchange = Exchange(io, settings, navigation)
        news = FrontEndNews(io, exchange)
        port = HostPort(io.memories["exchange"])
        output = PacedOutput(
            io, navigation, news, news, port=port, clock=news.clock, task_frames=settings.task_frames
        )
        exchange.updated = output.send_epoch
        words = Words(navigation, exchange, news, output)
        background = Background(io, navigation, news, output, Announcer(news.clock, news, output), words)
        port.begin()
        exchange.begin(output.send)
        background.run()

    def spoil(self) -> None:
        """Leave NaN in the velocity, as a defective kernel would."""
        if self._navigation is not None:
            self._navigation.spoil()

    def memory(self) -> bytes:
        """The navigation state as it lies in memory."""
        return b"" if self._navigation is None else self._navigation.memory()


class Background:
    """What `main` does after set-up, for ever."""

    def __init__(
        self,
        io: BoardIo,
        navigation: Navigation,
        news: FrontEndNews,
        output: PacedOutput,
        announcer: Announcer,
        words: Words,
    ) -> None:
        self._io = io
        self._navigation = navigation
        self._news = news
        self._output = output
        self._announcer = announcer
        self._words = words
        self._cost = io.cpu.cost("health_check")
        self._line = io.interrupts.attach("background_tick", self._on_tick)
        self._ticks = 0
        self._shown_ns = 0

    def run(self) -> None:
        """The loop; returns only when the processor is reset or switched off."""
        io = self._io
        io.watchdog.start(WATCHDOG_NS)
        io.timers["background"].start(RATE_HZ, self._line)
        done = 0
        while True:
            while self._ticks == done:
                io.cpu.wait_for_interrupt()
            done = self._ticks
            io.watchdog.kick()
            self._news.look()
            io.cpu.spend(self._cost)
            self._words.look()
            if self._words.imu_is_silent:
                self._show_state()
            self._announcer.look()
            if done % RATE_HZ == 0:
                self._output.send_slow()
                self._announcer.look_at_line()

    def _on_tick(self) -> None:
        self._ticks += 1

    def _show_state(self) -> None:
        """Without samples nothing drives the output: each epoch that moved the state is shown from here."""
        state_ns = self._navigation.state_ns
        if state_ns > self._shown_ns:
            self._shown_ns = state_ns
            self._output.send()
