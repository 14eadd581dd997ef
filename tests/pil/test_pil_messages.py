"""What the user gets wrong is told in one message, with exit code 2."""

import pytest
from typer.testing import CliRunner

from host.cli.main import app

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


@pytest.mark.parametrize(
    ("command", "package"),
    [(["pil", "uav_ahrs"], "qemu-system-arm"), (["build", "uav_ahrs"], "gcc-arm-none-eabi")],
)
def test_a_missing_tool_is_named_with_its_package(command, package, monkeypatch, capfd, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 2
    assert f"apt install {package}" in capfd.readouterr().err + result.stderr
