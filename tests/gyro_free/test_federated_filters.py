"""The filters of gfsins on the document's conditions: a short drive, and sensors that fail."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from firmware.nav.gyro_free.filters import FilterConfig, new_federation
from host.cli.main import app
from host.tables.chapter5 import Failure, chapter5
from host.tables.federated_run import run_federated, run_single


def invoke(*words: str):  # type: ignore[no-untyped-def]
    return CliRunner().invoke(app, ["table", *words])


@pytest.fixture(scope="module")
def central():  # type: ignore[no-untyped-def]
    return run_single(chapter5(130, 7), FilterConfig(), True, True)


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.sum(values[60:] ** 2, axis=1))))


@pytest.mark.parametrize("reset", ["no_reset", "fusion_feedback", "zero_reset", "proportional"])
def test_every_mode_converges_and_feedback_is_the_centralised_filter(reset, central) -> None:  # type: ignore[no-untyped-def]
    run = run_federated(chapter5(130, 7), FilterConfig(reset=reset))
    assert not run.isolated.any()
    ratios = [
        rms(getattr(run.master, name)) / rms(getattr(central, name))
        for name in ("attitude", "velocity", "position")
    ]
    assert max(ratios) < (1.05 if reset == "fusion_feedback" else 2.0)
    assert np.degrees(np.abs(run.master.attitude[60:])).max() < 0.5
    assert np.abs(run.master.position[60:]).max() < 12.0


@pytest.mark.parametrize(
    ("failure", "which", "within"),
    [
        (Failure("compass", "turned by 25°", 40.0, 100.0), 0, 2),
        (Failure("compass", "stuck", 40.0, 100.0), 0, 4),
        (Failure("gps", "silent", 40.0, 100.0), 1, 7),
        (Failure("gps", "300 m off", 40.0, 100.0), 1, 4),
    ],
    ids=lambda one: f"{one.sensor} {one.kind}" if isinstance(one, Failure) else "",
)
@pytest.mark.parametrize("reset", ["fusion_feedback", "proportional"])
def test_a_sensor_that_fails_is_isolated_and_trusted_again(failure, which, within, reset) -> None:  # type: ignore[no-untyped-def]
    run = run_federated(chapter5(130, 7, failure), FilterConfig(reset=reset))
    isolated = run.isolated[:, which]
    assert not run.isolated[:39].any()
    assert not run.isolated[:, 1 - which].any()
    assert isolated[40 + within : 99].all()
    assert not isolated[110:].any()
    assert run.recoveries[which] == 1
    assert np.linalg.norm(run.master.position[60:], axis=1).max() < 80.0
    assert np.degrees(np.abs(run.master.attitude[60:])).max() < 3.0


def test_the_table_tells_what_is_wrong_with_a_request() -> None:
    for words in (
        ("rates", "--arm", "0"),
        ("rates", "--duration", "1"),
        ("rates", "--seeds", "x"),
        ("federated", "--duration", "10"),
    ):
        result = invoke(*words)
        assert result.exit_code == 2, words
        assert "Traceback" not in result.output


def test_the_table_of_rates_as_json() -> None:
    result = invoke("rates", "--seeds", "1", "--duration", "4", "--json", "-", "-q")
    assert result.exit_code in (0, 1), result.output
    told = json.loads(result.stdout)
    assert len(told["rows"]) == 20
    assert told["met"] == all(row["met"] for row in told["rows"])


@pytest.mark.parametrize(
    ("field", "value"), [("reset", "sometimes"), ("rate_noise", 0.0), ("gates", (1.0, -1.0, 2.0))]
)
def test_a_wrong_configuration_says_which_field(field: str, value: object) -> None:
    with pytest.raises(ValueError, match=f"FilterConfig.{field}"):
        new_federation(FilterConfig(**{field: value}))
