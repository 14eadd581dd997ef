"""Profiles, arms and links that no board could have: one message, nothing run."""

from __future__ import annotations

import pytest

from host.record.errors import UserError
from host.record.result import RunRequest
from host.run.runner import run


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("profile.feed=gyros", "feed = 'gyros' is not possible"),
        ("profile.alignment_s=0", "alignment_s = 0 is no number from 2 to 600"),
        ("profile.declination_deg=true", "declination_deg = True"),
        ("board.chips.U4.lever_arm_m=[0.0, 0.0, 0.25]", "accelerometer4 sits at"),
        ("board.interconnects.packets.receiver=fpga", "sender and receiver are both 'fpga'"),
        ("board.interconnects.packets.clock_hz=1", "clock_hz"),
        ("board.interconnects.commands.address=4", "address"),
        ("board.interconnects.packets.kind=telepathy", "telepathy"),
        ("board.interconnects.commands.slave=gpu", "which the board does not have"),
        ('fault=[{kind="packet-loss", target="emif", at_s=1.0}]', "no packet link 'emif'"),
    ],
)
def test_refused(change: str, told: str) -> None:
    with pytest.raises(UserError, match=told.replace("[", r"\[")):
        run(RunRequest("gfsins", overrides=("duration_s=5", change), capture=False))
