"""The progress bar: speed as × real time, no flood, silence where nobody looks."""

import io

import pytest
from rich.console import Console

from host.cli import terminal


@pytest.fixture
def screen(monkeypatch):
    written = io.StringIO()
    console = Console(file=written, force_terminal=True, width=100, highlight=False)
    monkeypatch.setattr(terminal, "standard_error", lambda: console)
    return written


def test_the_bar_tells_virtual_time_and_speed(screen, monkeypatch):
    clock = iter([10.0, 11.0, 12.0])
    monkeypatch.setattr(terminal.time, "monotonic", lambda: next(clock))
    with terminal.progress_bar("car_mems town", quiet=False) as progress:
        progress(0.0, 1200.0)
        progress(600.0, 1200.0)
        progress(1200.0, 1200.0)
    assert "600/1,200 s" in screen.getvalue()
    assert "600 × real time" in screen.getvalue()


def test_frequent_calls_are_not_all_drawn(screen, monkeypatch):
    monkeypatch.setattr(terminal.time, "monotonic", lambda: 10.0)
    with terminal.progress_bar("car_mems town", quiet=False) as progress:
        before = len(screen.getvalue())
        for step in range(1000):
            progress(step, 5000.0)
        assert len(screen.getvalue()) - before < 2000


def test_no_bar_when_quiet(screen):
    with terminal.progress_bar("car_mems town", quiet=True) as progress:
        assert progress is None


def test_no_bar_in_a_file(monkeypatch):
    monkeypatch.setattr(terminal, "standard_error", lambda: Console(file=io.StringIO()))
    with terminal.progress_bar("car_mems town", quiet=False) as progress:
        assert progress is None
