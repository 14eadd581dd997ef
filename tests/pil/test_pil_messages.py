"""What the user gets wrong is told in one message, with exit code 2."""

import pytest
from typer.testing import CliRunner

from host.cli.main import app
from host.pil.toolchain import run_tool
from host.record.errors import UserError

WRONG = {
    "--steps 0": ["pil", "uav_ahrs", "--steps", "0"],
    "--plant nothing: not known; one of fma, constant, rounding": ["pil", "uav_ahrs", "--plant", "nothing"],
    "leave out --port": ["pil", "uav_ahrs", "--plant", "fma", "--port", "/dev/ttyS99"],
    "no board 'nothing'": ["pil", "nothing"],
    "--target esp32: not known; for example --target stm32f405": ["build", "car_mems", "--target", "esp32"],
    "name a folder": ["build", "car_mems", "--out", __file__],
}


@pytest.mark.parametrize("message", WRONG)
def test_a_wrong_option_is_one_message(message, capfd):
    result = CliRunner().invoke(app, WRONG[message])
    told = capfd.readouterr().err + result.stderr
    assert result.exit_code == 2
    assert message in told
    assert len(told.strip().splitlines()) == 1


COMPILER = "apt install gcc-arm-none-eabi libnewlib-arm-none-eabi"
NO_TOOLS = {
    f"{COMPILER} qemu-system-arm\n": ["pil", "uav_ahrs"],
    f"{COMPILER}\n": ["build", "uav_ahrs"],
    "no board 'nothing'": ["pil", "nothing"],
    "has no module stand_alone": ["pil", "uav_ahrs", "--stand-alone"],
    "computes in float64": ["build", "uav_ahrs", "--profile", "float64"],
}


@pytest.mark.parametrize("message", NO_TOOLS)
def test_missing_tools_are_named_with_their_packages_once_the_request_makes_sense(
    message, monkeypatch, capfd, tmp_path
):
    monkeypatch.setenv("PATH", str(tmp_path))
    result = CliRunner().invoke(app, NO_TOOLS[message])
    told = capfd.readouterr().err + result.stderr
    assert result.exit_code == 2
    assert message in told
    assert len(told.strip().splitlines()) == 1


def test_a_tool_missing_behind_the_compiler_is_named_with_its_package(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(UserError, match="apt install binutils-arm-none-eabi"):
        run_tool("arm-none-eabi-objcopy", "--version")
