"""Tables of gfsins on its board: what was asked is checked first; arms of a length of one's own."""

import pytest
from typer.testing import CliRunner

from boards.description import load_board
from boards.validation import DescriptionError
from host.cli.main import app
from host.sim.scenario.overrides import apply_overrides


@pytest.mark.parametrize("arms", ["", "0.25,x", "0", "nan", "0.25,11"])
def test_arms_that_cannot_be_are_refused(arms: str) -> None:
    result = CliRunner().invoke(app, ["table", "arms", "--arms", arms])
    assert result.exit_code == 2
    assert "--arms" in result.output
    assert "Traceback" not in result.output


def test_one_number_moves_the_chips_of_all_six_arms() -> None:
    board = load_board("gfsins", lambda data: apply_overrides(data, ["arm_length_m=0.7"]))
    places = [board.chips[f"U{k}"].lever_arm_m for k in range(1, 8)]
    assert places == [
        (0, 0.7, 0),
        (0, 0, 0.7),
        (0.7, 0, 0),
        (0, 0, -0.7),
        (-0.7, 0, 0),
        (0, -0.7, 0),
        (0, 0, 0),
    ]


def test_a_lever_arm_of_its_own_wins_and_a_length_is_needed() -> None:
    moved = load_board("gfsins", lambda data: apply_overrides(data, ["chips.U1.lever_arm_m=[0.0, 0.3, 0.0]"]))
    assert moved.chips["U1"].lever_arm_m == (0.0, 0.3, 0.0)
    assert moved.chips["U2"].lever_arm_m == (0.0, 0.0, 0.25)
    with pytest.raises(DescriptionError, match="chip U1 sits on an arm: the board needs arm_length_m"):
        load_board("gfsins", lambda data: {k: v for k, v in data.items() if k != "arm_length_m"})
    with pytest.raises(DescriptionError, match="arm_length_m = -1"):
        load_board("gfsins", lambda data: apply_overrides(data, ["arm_length_m=-1"]))
