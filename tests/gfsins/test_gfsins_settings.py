"""Settings mode as its operator meets it: what stands on the display, and what keys bring about."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from board_run import fault

from host.record.result import RunRequest
from host.run.session import open_session

S = 1_000_000_000
USUAL = ("panel.mode=settings", "panel.keys=[]", "expect={}")


class Operator:
    """Somebody before the board. Every press is followed by a look half a second later."""

    def __init__(self, *overrides: str) -> None:
        self.closing = ExitStack()
        request = RunRequest("gfsins", "static", overrides=(*USUAL, *overrides), capture=False)
        self.session = self.closing.enter_context(open_session(request))
        assert self.session.panel is not None
        self.panel = self.session.panel

    def until(self, seconds: float) -> list[str]:
        self.session.run_until(round(seconds * S))
        return self.panel.lines()

    def press(self, *keys: str) -> list[str]:
        for key in keys:
            self.panel.press(key)
            self.until(self.session.now_ns / S + 0.3)
        return self.until(self.session.now_ns / S + 0.2)

    def words(self) -> list[str]:
        result = self.session.finish(1.0)
        return [event.text for event in result.events if event.source == "board"]


@pytest.fixture
def operator() -> Iterator[Operator]:
    made = Operator()
    with made.closing:
        yield made


def reading(lines: list[str]) -> float:
    """In g."""
    return float(lines[4].removeprefix("reads").removesuffix("g"))


def test_scale_and_offset_are_edited_within_limits_and_act_in_both_modes(operator: Operator) -> None:
    assert operator.until(0.1) == ["gfsins settings mode", "", "sensors start ...", "", "", "", "", ""]
    assert operator.until(1.8)[0] == "! DSP is silent"
    first = operator.until(3.0)
    assert first[0].startswith("SETTINGS")
    assert first[1:3] == ["Status", "Scale and offset"]
    assert operator.press("OK")[0] == "STATUS"
    shown = operator.panel.lines()
    assert shown[1] == "chips           all 7"
    assert shown[2:5] == ["compass            ok", "GPS            set up", "GPS epochs          2"]
    assert shown[5:] == ["DSP           answers", "calibration      none", "keys               ok"]
    assert operator.press("BACK", "DOWN", "OK", "DOWN")[2] == "A2 1.00000    +0.0 mg"
    before = operator.press("OK")
    assert before[:4] == [
        "Accelerometer A2",
        "scale         1.00000",
        "offset        +0.0 mg",
        "back to nominal",
    ]
    edited = operator.press("DOWN", "OK", "LEFT", "LEFT", "LEFT", "UP", "UP", "UP", "UP")
    assert edited[0] == "A2 offset, mg"
    assert edited[2].strip() == "+400.0"
    assert operator.press("UP")[5] == "that is the limit"
    after = operator.press("OK")
    assert after[2] == "offset      +400.0 mg"
    settled = operator.until(operator.session.now_ns / S + 1.0)
    assert reading(settled) - reading(before) == pytest.approx(-0.4, abs=0.003)
    assert operator.press("UP", "OK", "LEFT", "LEFT", "LEFT", "LEFT", "UP")[2].strip() == "1.10000"
    assert operator.press("UP")[5] == "that is the limit"
    assert operator.press("BACK")[1] == "scale         1.00000"
    assert operator.press("BACK", "BACK", "UP", "UP")[7] == "Leave"
    assert operator.press("OK")[:3] == ["Leave settings?", "No", "Yes, start"]
    operator.press("DOWN", "OK")
    assert not operator.panel.picture().any()
    operator.until(operator.session.now_ns / S + 12.0)
    words = operator.words()
    assert words.index("acquisition is in settings mode") < words.index("acquisition has left settings mode")
    assert "accelerometers swapped or turned: A2" in words


def test_what_was_edited_outlives_a_reset() -> None:
    operator = Operator(f"fault=[{fault('cpu-reset', 'fpga', 9.0)}]")
    with operator.closing:
        operator.until(2.9)
        operator.press("DOWN", "OK", "OK", "OK", "LEFT", "LEFT", "UP", "OK")
        assert operator.panel.lines()[1] == "scale         1.00100"
        operator.press("DOWN", "OK", "DOWN", "OK")
        assert operator.until(8.9)[2] == "offset        -0.5 mg"
        operator.until(11.5)
        assert operator.press("DOWN", "OK")[1:3] == ["A1 1.00100    -0.5 mg", "A2 1.00000    +0.0 mg"]
        assert operator.press("OK", "DOWN", "DOWN", "OK")[1:3] == [
            "scale         1.00000",
            "offset        +0.0 mg",
        ]
        assert operator.session.board.chips["U8"].reports == [], "the compass was running, and got its delays"


ON_MOSI = '{ probability = 0.02, line = "mosi" }'
FAULTS = [
    fault("spi-missing", "accelerometer3", 3.0, 3.0),
    fault("chip-off", "U10", 8.0, 1.0),
    fault("spi-bit-errors", "display", 12.0, 1.0).replace("}", f", parameters = {ON_MOSI} }}"),
    fault("cpu-reset", "fpga", 18.0),
    fault("cpu-reset", "dsp", 22.0),
    *(fault("cpu-reset", "dsp", 24.5 + 0.9 * k) for k in range(5)),
    fault("chip-off", "U8", 31.0, 2.0),
]


def test_faults_are_told_on_the_screen_and_nothing_hangs() -> None:
    operator = Operator(f"fault=[{', '.join(FAULTS)}]")
    with operator.closing:
        title = operator.until(2.9)[0]
        assert title.startswith("SETTINGS")
        assert operator.until(4.5)[0] == "! no chip 3"
        assert operator.press("OK")[1] == "chips            no 3"
        assert operator.press("BACK")[0] == "! no chip 3"
        assert operator.until(7.0)[0] == title
        operator.until(8.5)
        assert not operator.panel.picture().any()
        operator.press("DOWN")
        whole = operator.until(11.5)
        assert whole[0].startswith("SETTINGS")
        assert operator.panel.picture().any()
        operator.until(12.9)
        assert operator.until(15.5) == whole
        assert operator.until(20.5)[0] == title
        assert operator.until(24.0)[0] == title
        assert operator.until(28.5)[0] == "! DSP is silent"
        assert operator.until(30.5)[0] == title
        assert operator.until(32.5)[0] == "! no compass"
        assert operator.press("OK")[2] == "compass       missing"
        assert operator.press("BACK")[0] == "! no compass"
        assert operator.until(45.0)[0] == title
        assert operator.press("UP", "OK")[0] == "Leave settings?"
        causes = [[cause for _, cause in cpu.resets] for cpu in operator.session.board.cpus.values()]
        assert (len(causes[0]), len(causes[1])) == (1, 6)
        assert all(placed.fired() for placed in operator.session.faults)


def test_a_key_that_is_stuck_from_the_beginning_is_told_and_left_alone() -> None:
    operator = Operator(f"fault=[{fault('pin-stuck', 'KEY_BACK', 0.0)}]")
    with operator.closing:
        assert operator.until(3.0)[0] == "! key stuck: BACK"
        assert operator.press("DOWN", "OK")[0].startswith("Scale, offset")
        assert operator.press("DOWN", "OK")[0] == "Accelerometer A2"


def test_other_codes_of_the_mode_inputs_mean_acquisition() -> None:
    both = "board.chips.S2.parameters.positions={ acquisition = [0, 0], settings = [1, 1] }"
    operator = Operator(both)
    with operator.closing:
        assert operator.until(1.0) == [""] * 8
        operator.session.board.chips["S2"].turn_to("acquisition")
