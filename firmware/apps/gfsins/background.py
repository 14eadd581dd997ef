"""What the DSP's main does after set-up, for ever: ten times a second."""

from __future__ import annotations

import math

from firmware.apps.gfsins.acquisition_news import AcquisitionNews
from firmware.apps.gfsins.filter_frames import FilterFrames
from firmware.apps.gfsins.flight import Flight
from firmware.apps.gfsins.solver import Solver
from firmware.apps.gfsins.words import Words
from firmware.apps.gnss_ins.announcements import Announcer
from firmware.apps.gnss_ins.output import Output
from hal.board_io import BoardIo

RATE_HZ = 10
WATCHDOG_NS = 2_000_000_000
LONGEST_WAIT_NS = 50_000_000
AGES_EVERY = 600
"""Looks from one report of the age of data to the next."""


class Background:
    """The loop."""

    def __init__(
        self,
        io: BoardIo,
        news: AcquisitionNews,
        output: Output,
        announcer: Announcer,
        words: Words,
        flight: Flight,
        solver: Solver,
        filters: FilterFrames,
    ) -> None:
        self._io = io
        self._news = news
        self._output = output
        self._announcer = announcer
        self._words = words
        self._flight = flight
        self._solver = solver
        self._filters = filters
        self._told_calibration = False
        self._cost = io.cpu.cost("health_check")
        self._line = io.interrupts.attach("background_tick", self._on_tick)
        self._ticks = 0
        self._misplaced: tuple[str, ...] = ()
        self._restarts = self._realignments = 0

    def run(self) -> None:
        """Returns only when the processor is reset or switched off."""
        io = self._io
        io.watchdog.start(WATCHDOG_NS)
        io.timers["background"].start(RATE_HZ, self._line)
        done = 0
        while True:
            while self._ticks == done:
                io.cpu.wait_for_interrupt()
            done = self._ticks
            io.watchdog.kick()
            io.cpu.spend(self._cost)
            if done % RATE_HZ == 0:
                self._news.ask()
                self._wait_for_solution()
                self._output.send_slow()
                self._filters.send()
                self._announcer.look_at_line()
            self._words.look()
            self._announcer.look()
            self._look_at_alignment()
            self._look_at_calibration()
            self._solver.look()
            if done % AGES_EVERY == 0:
                self._tell_ages()

    def _wait_for_solution(self) -> None:
        """What goes to the host once a second holds its line for some 30 ms: it goes behind a solution, so
        that none is behind it. Without packets there is none to wait for."""
        io = self._io
        latest_ns = io.clock.now_ns() + LONGEST_WAIT_NS
        while self._flight.is_solution_near and io.clock.now_ns() < latest_ns:
            io.cpu.wait_for_interrupt()

    def _on_tick(self) -> None:
        self._ticks += 1

    def _look_at_alignment(self) -> None:
        flight = self._flight
        if flight.beginning is not None:
            yaw, pitch, roll = flight.beginning
            flight.beginning = None
            self._news.tell_alignment(yaw, pitch, roll)
            angles = ", ".join(f"{math.degrees(angle):.1f}" for angle in (yaw % math.tau, pitch, roll))
            self._output.send_text(f"aligned: heading, pitch, roll {angles} deg")
        if flight.restarts != self._restarts:
            self._restarts = flight.restarts
            self._output.send_text("state not a number: begun again with a sound filter")
        if flight.is_entered_refused:
            flight.is_entered_refused = False
            self._output.send_text("what was entered is not of here: alignment's is taken")
        if flight.realignments != self._realignments:
            self._realignments = flight.realignments
            self._output.send_text(f"attitude lost, {flight.lost_by}: aligning again")
        misplaced = flight.alignment.misplaced
        if misplaced != self._misplaced:
            self._misplaced = misplaced
            if misplaced:
                self._output.send_text(f"accelerometers swapped or turned: {', '.join(misplaced)}")

    def _look_at_calibration(self) -> None:
        found = self._flight.coefficients
        if not self._told_calibration and (found.is_used or found.is_spoilt):
            self._told_calibration = True
            told = "loaded" if found.is_used else "in flash is spoilt: nominal values"
            self._output.send_text(f"calibration {told}")

    def _tell_ages(self) -> None:
        flight = self._flight
        if flight.solutions:
            mean_ms = flight.ages_ns / flight.solutions * 1e-6
            worst_ms = flight.oldest_ns * 1e-6
            self._output.send_text(f"tick to solution: {mean_ms:.2f} ms, at most {worst_ms:.2f} ms")
