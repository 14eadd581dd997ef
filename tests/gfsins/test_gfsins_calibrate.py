"""`navtwin calibrate` from the panel's keys to the next power-up, on a line that loses packets."""

from __future__ import annotations

import json
import math
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from board_run import fault

from firmware.apps.gfsins import calibration as cal
from firmware.apps.gfsins.calibration_store import pack, unpack
from host.calibrate.job import procedures_of
from host.cli.calibrate_run import Outputs, execute
from host.record.errors import UserError
from host.record.result import RunRequest
from host.run.runner import run

FAULTS = (
    fault("spi-missing", "accelerometer3", 12.0, 3.0),
    fault("packet-loss", "packets", 40.0, 40.0, probability=0.2),
    fault("packet-bit-errors", "packets", 40.0, 40.0, probability=3e-4),
    fault("cpu-reset", "dsp", 49.0),
    fault("sensor-stuck", "U5", 59.5, 6.0),
)
TRUE_SCALE_LIMIT, TRUE_OFFSET_LIMIT = 8e-4, 0.4


@dataclass
class Told:
    code: int
    figures: dict[str, Any]
    store: bytes
    page: str


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> Told:
    """Twelve positions and an alignment, with trouble on the way."""
    folder = tmp_path_factory.mktemp("calibrated")
    outputs = Outputs(folder / "store.bin", folder / "page.html", str(folder / "figures.json"), True)
    request = RunRequest("gfsins", seed=4, overrides=(f"fault=[{', '.join(FAULTS)}]",))
    code = execute(request, ["alignment", "accelerometers"], outputs)
    assert outputs.store is not None
    assert outputs.page is not None
    figures = json.loads((folder / "figures.json").read_text(encoding="utf-8"))
    return Told(code, figures, outputs.store.read_bytes(), outputs.page.read_text(encoding="utf-8"))


def procedure(told: Told, name: str) -> dict[str, Any]:
    found: dict[str, Any] = next(one for one in told.figures["procedures"] if one["name"] == name)
    return found


def test_all_is_met_in_spite_of_the_faults(told: Told) -> None:
    assert told.code == 0
    assert told.figures["met"] is True
    assert told.figures["format"] == "navtwin-calibration-1"
    assert [one["name"] for one in told.figures["procedures"]] == ["accelerometers", "alignment"]


def test_a_missing_chip_is_told_on_the_screen_and_the_position_taken_again(told: Told) -> None:
    refusals = procedure(told, "accelerometers")["refusals"]
    assert refusals
    assert set(refusals) == {"chip 3 is missing"}


def test_a_stuck_chip_is_told_as_stuck(told: Told) -> None:
    assert set(procedure(told, "alignment")["refusals"]) == {"chip 5 is stuck"}


def test_coefficients_are_those_of_the_sensors(told: Told) -> None:
    coefficients = procedure(told, "accelerometers")["coefficients"]
    assert len(coefficients) == 18
    for one in coefficients:
        limit = TRUE_SCALE_LIMIT if "scale" in one["name"] else TRUE_OFFSET_LIMIT
        assert abs(one["found"] - one["true"]) < limit, one
        assert 0.0 < one["sigma"] < limit
    left = next(one for one in procedure(told, "accelerometers")["figures"] if "origin" in one["name"])
    assert left["value"] < left["before"] / 50.0


def test_the_screen_says_what_was_found(told: Told) -> None:
    screen = procedure(told, "accelerometers")["screen"]
    assert screen[0].startswith("scale 0.99")
    assert screen[-1] == "stored"
    tilt = next(one for one in procedure(told, "alignment")["figures"] if one["name"] == "tilt")
    assert tilt["value"] < 0.1


def test_the_page_opens_offline_and_holds_the_tables(told: Told) -> None:
    assert "Calibration against the truth" in told.page
    assert "A7 offset" in told.page
    assert "http://" not in told.page.split("<script>")[0]


def power_up(folder: Path, *blocks: bytes) -> list[str]:
    """What the board tells in twelve seconds of acquisition with that in its flash."""
    file = folder / "store.bin"
    file.write_bytes(b"".join(block.ljust(2112, b"\xff") for block in blocks))
    changes = (
        f'board.flash.calibration.file="{file}"',
        "duration_s=13.0",
        "segment=[{kind='rest',duration_s=13.0}]",
    )
    request = RunRequest("gfsins", "iron", profile="adxl345", overrides=(*changes, "initial.speed_mps=0.0"))
    return [event.text for event in run(request).events if event.source == "board"]


def heading(events: list[str]) -> float:
    told = next(text for text in events if text.startswith("aligned"))
    return float(told.split()[4].rstrip(","))


def test_the_next_power_up_uses_what_is_stored_and_nothing_that_is_spoilt(tmp_path: Path) -> None:
    turned = math.radians(7.0)
    image = pack({cal.DEVIATION: struct.pack(">10f", turned, *[0.0] * 4, *[0.001] * 5)}, 1)
    wrong = bytearray(image)
    wrong[20] ^= 1
    spoilt = power_up(tmp_path, bytes(wrong), b"")
    assert "calibration in flash is spoilt: nominal values" in spoilt
    assert not any("calibration loaded" in text for text in spoilt)
    loaded = power_up(tmp_path, bytes(wrong), image)
    assert "calibration loaded" in loaded
    assert math.remainder(heading(spoilt) - heading(loaded), 360.0) == pytest.approx(7.0, abs=0.3)


@pytest.mark.parametrize(
    ("request_", "asked", "message"),
    [
        (RunRequest("car_mems"), [], "keeps no calibration"),
        (RunRequest("gfsins", "chapter5"), ["compass"], "its vehicle moves"),
        (RunRequest("gfsins"), ["compas"], "did you mean 'compass'"),
        (RunRequest("gfsins", overrides=('panel.keys=[[1.0,"OK"]]',)), ["compass"], "leave them out"),
        (RunRequest("gfsins", overrides=("board.flash.calibration.file=none.bin",)), [], "No such file"),
        (RunRequest("gfsins", overrides=("board.flash.calibration.file=pyproject.toml",)), [], "has 4224"),
    ],
)
def test_what_cannot_be_calibrated_is_told(request_: RunRequest, asked: list[str], message: str) -> None:
    with pytest.raises(UserError, match=message):
        execute(request_, asked, Outputs(None, None, None, True))


def test_a_spoilt_store_is_calibrated_anew(tmp_path: Path) -> None:
    file, target = tmp_path / "spoilt.bin", tmp_path / "store.bin"
    file.write_bytes(bytes(4224))
    request = RunRequest("gfsins", overrides=(f'board.flash.calibration.file="{file}"',))
    assert execute(request, ["alignment"], Outputs(target, None, None, True)) == 0
    blocks = [unpack(target.read_bytes()[place : place + 2112]) for place in (0, 2112)]
    written = [block for block in blocks if block is not None]
    assert [set(sections) for _, sections in written] == [{cal.CORRECTIONS, cal.ALIGNMENT}]


def test_a_reset_that_leaves_the_operator_on_another_page_costs_one_procedure(tmp_path: Path) -> None:
    target = tmp_path / "figures.json"
    request = RunRequest("gfsins", overrides=(f"fault=[{fault('cpu-reset', 'fpga', 11.5)}]",))
    outputs = Outputs(None, None, str(target), True)
    assert execute(request, ["accelerometers", "alignment"], outputs) == 1
    lost, found = json.loads(target.read_text(encoding="utf-8"))["procedures"]
    assert (lost["done"], lost["screen"]) == (False, ["the board has begun anew"])
    assert found["done"]


def test_procedures_come_in_the_order_in_which_they_build_on_each_other() -> None:
    assert procedures_of(["compass", "accelerometers"]) == ("accelerometers", "compass")
    assert procedures_of([]) == ("accelerometers", "rates", "compass", "alignment")
    assert len(procedures_of(["all"])) == 6


@pytest.mark.soak
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_all_procedures_are_met_by_other_specimens(seed: int, tmp_path: Path) -> None:
    target = tmp_path / "figures.json"
    assert execute(RunRequest("gfsins", seed=seed), ["all"], Outputs(None, None, str(target), True)) == 0
    found = json.loads(target.read_text(encoding="utf-8"))
    assert all(abs(row["calibrated_error_deg"]) < 0.6 for row in found["power_ups"])
    earth = next(one for one in found["procedures"] if one["name"] == "earth-rate")
    assert "not observable" in earth["screen"]
