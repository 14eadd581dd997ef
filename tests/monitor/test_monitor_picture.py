"""The picture: golden snapshots, every size, what must be readable, and nothing that a terminal obeys."""

import io
import math
import os
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as some
from rich.cells import cell_len
from rich.console import Console
from spoken_drive import LAT, LON, place, solution, spoken, write_capture
from typer.testing import CliRunner

from firmware.link import frames
from host.cli.main import app
from host.monitor.figures import figures_line
from host.monitor.view import MonitorView
from host.monitor.words import utc

GOLDEN = Path(__file__).parent / "golden"
WRITE = "NAVTWIN_WRITE_GOLDEN"
"""Set it to write the snapshots anew; the change is then reviewed as a diff."""


def told(pieces) -> MonitorView:
    view = MonitorView("a board")
    for time_ns, data in pieces:
        view.feed(data, time_ns / 1e9)
    return view


def picture(view: MonitorView, width: int, height: int, **console) -> str:
    out = io.StringIO()
    Console(file=out, width=width, height=height, **console).print(view.render(width, height), end="")
    return out.getvalue()


@pytest.fixture(scope="module")
def drive():
    return told(spoken(62))


@pytest.mark.parametrize("size", ["80x24", "120x40", "160x50", "40x30"])
def test_snapshot_of_a_capture(size, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_capture(Path("drive.mcap"), spoken(62))
    result = CliRunner().invoke(app, ["monitor", "drive.mcap", "--once", "--size", size])
    assert result.exit_code == 0, result.output
    golden = GOLDEN / f"{size}.txt"
    if os.environ.get(WRITE):
        golden.parent.mkdir(exist_ok=True)
        golden.write_text(result.output, encoding="utf-8")
    assert result.output == golden.read_text(encoding="utf-8")


@settings(max_examples=40, deadline=None)
@given(some.integers(-3, 200), some.integers(-3, 70))
def test_every_size_is_filled_exactly(drive, width, height):
    for view in (drive, MonitorView("nobody")):
        lines = picture(view, max(width, 1), max(height, 1)).split("\n")
        assert lines.pop() == ""
        assert len(lines) == max(height, 1)
        assert {cell_len(line) for line in lines} == {max(width, 1)}


def test_what_must_be_readable_at_80_by_24(drive):
    text = picture(drive, 80, 24)
    lat, lon, yaw = place(62.0)
    for words in (
        f"{lat * 1e-9:.7f}° N",
        f"{lon * 1e-9:.7f}° E",
        f"yaw   {math.degrees(yaw):8.2f}°",
        "pitch    -3.00°",
        "roll      8.00°",
        "36.0 km/h",
        "2024-03-15 09:01:02.0",
        "navigating",
        "constrained",
        "G05*47",
        "R78*33",
        "missed 0",
        "IMU samples missing",
    ):
        assert words in text, words
    assert "navigation    3.10%" in text


def test_the_scale_bar_tells_the_length_of_the_track(drive):
    """62 s at 10 m/s on a circle of 200 m: half of it, 400 m from north to south and 200 m wide."""
    points = drive.state.track.fused.points
    east = [e for _, e in points]
    north = [n for n, _ in points]
    assert max(east) - min(east) == pytest.approx(200.0, abs=1.5)
    assert max(north) - min(north) == pytest.approx(400.0, abs=1.0)
    text = picture(drive, 120, 40)
    (bar,) = [line for line in text.splitlines() if "├─" in line]
    start = bar.index("├─")
    length = bar.index("┤", start) - start + 1
    metres = float(bar[bar.index("┤", start) + 1 :].split()[0])
    rows = [line[82:118] for line in text.splitlines()[2:25]]
    drawn = [row for row in rows if any("\u2801" <= sign <= "\u28ff" or sign in "↑↗→↘↓↙←↖" for sign in row)]
    assert 2 * len(drawn) * metres / length == pytest.approx(400.0, rel=0.12)


@pytest.mark.parametrize(("pitch", "roll"), [(0, 0), (8, 0), (-8, 0), (0, 20), (0, -20), (5, 179)])
def test_the_horizon_stands_as_from_the_cockpit(pitch, roll):
    """Nose up: the horizon lies below the middle. Right side down: its right end is higher than its left."""
    from host.monitor.horizon import horizon

    lines = horizon(pitch, roll, 30, 11)
    text = [line.plain.ljust(30) for line in lines]
    styles = [{at: span.style for span in line.spans for at in range(span.start, span.end)} for line in lines]
    rows = {
        column: [
            row for row in range(11) if styles[row].get(column) == "bold cyan" and text[row][column] != " "
        ]
        for column in (3, 26)
    }
    left, right = (sum(rows[c]) / len(rows[c]) for c in (3, 26))
    if abs(roll) < 90:
        assert (right < left) == (roll > 0)
    middle = (left + right) / 2
    if pitch and abs(roll) < 90:
        assert (middle > 5) == (pitch > 0)
    if roll == 179:  # upside down the ground is above, so the horizon is, with the nose up, above the middle
        assert middle < 5


def test_no_colour_where_none_is_wanted(drive, monkeypatch):
    monkeypatch.setenv("NO_COLOR", "1")
    plain = picture(drive, 100, 30, force_terminal=True, color_system="truecolor")
    monkeypatch.delenv("NO_COLOR")
    colourful = picture(drive, 100, 30, force_terminal=True, color_system="truecolor")
    assert "\x1b[" in colourful
    codes = {c for part in plain.split("\x1b[")[1:] for c in part.partition("m")[0].split(";")}
    assert codes <= {"0", "1", "2", "7"}
    assert "\x1b" not in picture(drive, 100, 30)


def test_an_ascii_terminal_gets_ascii(drive):
    raw = io.BytesIO()
    out = io.TextIOWrapper(raw, encoding="ascii", errors="strict")
    console = Console(file=out, width=120, height=40)
    console.print(drive.render(120, 40), end="")
    out.flush()
    lines = raw.getvalue().decode("ascii").split("\n")
    assert {len(line) for line in lines[:-1]} == {120}
    assert "48.09" in lines[2]


def test_words_of_the_board_cannot_steer_the_terminal():
    view = MonitorView("a board")
    writer = frames.FrameWriter()
    view.feed(writer.text("\x1b[2J\x07 evil\r\n[red]words[/red]"), 1.0)
    rows = [("\x1b[31mtask\n", 1, 1, 1, 1)]
    view.feed(b"".join(writer.tasks(1_000_000, rows)), 1.0)
    text = picture(view, 120, 40)
    assert "\x1b" not in text
    assert "\x07" not in text
    assert "evil··[red]words[/red]" in text


def test_a_red_word_for_what_is_lost():
    view = MonitorView("a board")
    view.feed(solution(frames.FrameWriter(), 1.0, mode=4, flags=1 << 12 | 1 << 13), 1.0)
    coloured = picture(view, 120, 40, force_terminal=True, color_system="standard")
    assert "\x1b[1;31mgnss_lost\x1b[0m" in coloured
    assert "\x1b[1;31mdegraded\x1b[0m" in coloured


@settings(max_examples=40, deadline=None)
@given(
    some.lists(
        some.tuples(some.sampled_from(sorted(frames.PAYLOADS)), some.binary(max_size=255)), max_size=12
    )
)
def test_any_payload_can_be_shown(payloads):
    """Frames of right type and length, whatever stands in them: NaN, infinities, times at random."""
    view = MonitorView("noise")
    writer = frames.FrameWriter()
    for k, (kind, noise) in enumerate(payloads):
        size = frames.PAYLOADS[kind].size
        payload = (noise * (size // max(len(noise), 1) + 1) + bytes(size))[:size]
        view.feed(writer.frame(kind, payload), k * 0.1)
    for size in ((80, 24), (160, 50), (30, 12)):
        picture(view, *size)
    figures_line(view)


@settings(max_examples=60, deadline=None)
@given(some.lists(some.binary(max_size=300), max_size=8), some.integers(0, 9))
def test_garbage_never_raises(pieces, kind):
    view = MonitorView("noise")
    writer = frames.FrameWriter()
    for k, data in enumerate(pieces):
        view.feed(data + writer.frame(kind, data[:255]), k * 0.3)
    picture(view, 120, 40)
    figures_line(view)


def test_a_day_of_talk_stays_small():
    """Histories are bounded; the track keeps its shape by halving."""
    view = MonitorView("for ever")
    writer = frames.FrameWriter()
    for k in range(6000):
        t = k * 0.7
        lat, lon = round((LAT + k * 1e-5) * 1e9), round(LON * 1e9)
        view.state.track.add_fused(lat, lon, 0.0)
        view.feed(writer.text(f"event {k}") + writer.pack(frames.INNOVATION, k, 63, *[0.0] * 12), t)
    track = view.state.track.fused
    assert len(track.points) <= 801
    assert track.points[0] == (0.0, 0.0)
    assert max(n for n, _ in track.points) == pytest.approx(6000 * 1.112, rel=0.01)
    assert len(view.state.events) == 200
    assert len(view.state.innovations) == 120
    assert "event 5999" in picture(view, 80, 24)


def test_what_has_stopped_is_told(drive):
    view = told(spoken(12))
    assert "no solution" not in picture(view, 80, 24)
    view.time_passes(20.0)
    text = picture(view, 80, 24)
    assert "no solution for 8 s" in text
    assert "no epoch for 8 s" in text


def test_lateness_is_no_drift_of_clocks():
    """Half an hour with a board clock that is 100 ppm slow: a frame 30 ms late is told as such, the 180 ms
    by which the clocks have come apart are not."""
    view = MonitorView("a board")
    writer = frames.FrameWriter()
    for k in range(1, 3600):
        board_s = k * 0.5
        late_s = 0.03 if k == 3599 else 0.0
        view.feed(solution(writer, board_s), board_s * 1.0001 + late_s)
    assert view.link.late_ms == pytest.approx(30.0, abs=13.0)
    assert view.link.worst_late_ms < 45.0


def test_a_leap_second_is_told_as_one():
    assert utc(86_399_950, 16_140) == "2024-03-15 23:59:59.9"
    assert utc(86_400_500, 16_140) == "2024-03-15 23:59:60.5"
    assert utc(0xFFFF_FFFF, 0xFFFF) == "-"
