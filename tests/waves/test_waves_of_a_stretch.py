"""A short window of a finished capture: only what lies around it is read, and drawn as from the whole."""

from __future__ import annotations

from pathlib import Path

import pytest

from host.capture.reader import CaptureReader
from host.capture.stretch import StretchReader
from host.record.result import RunRequest
from host.run.runner import run
from host.waves.drawing import WavesRequest, draw

NS = 1_000_000_000


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run")
    run(RunRequest("car_mems", "static", None, 1, ("duration_s=60",), out_dir=folder / "out"))
    return folder / "out" / "run.mcap"


def without_index(capture: Path, folder: Path) -> Path:
    """The same capture without the end that holds the index."""
    cut = folder / "cut.mcap"
    cut.write_bytes(capture.read_bytes()[:-9])
    return cut


def drawn(capture: Path, target: Path, from_s: float, to_s: float | None) -> bytes:
    draw(WavesRequest(capture, target, from_s=from_s, to_s=to_s))
    return target.read_bytes()


@pytest.mark.parametrize(("from_s", "to_s"), [(59.9, None), (44.0, 44.2)])
def test_a_window_is_drawn_as_from_the_whole(
    capture: Path, tmp_path: Path, from_s: float, to_s: float | None
) -> None:
    whole = drawn(without_index(capture, tmp_path), tmp_path / "whole.vcd", from_s, to_s)
    assert drawn(capture, tmp_path / "stretch.vcd", from_s, to_s) == whole
    assert whole.count(b"\n#") > 100


def test_only_the_chunks_around_are_read(capture: Path) -> None:
    whole = [window.end_ns for window in CaptureReader(capture).windows()]
    reader = StretchReader(capture, 30 * NS, 31 * NS)
    part = [window.end_ns for window in reader.windows()]
    assert set(part) <= set(whole)
    assert part[0] <= 31 * NS
    assert part[-2] >= 31 * NS
    assert len(part) < 6
    assert reader.manifest["board"] == "car_mems"
    assert reader.end_ns == 60 * NS
    assert reader.format == format_of(capture)


def format_of(capture: Path) -> str:
    reader = CaptureReader(capture)
    next(reader.windows())
    return reader.format
