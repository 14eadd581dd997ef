"""Every kind of fault on a short drive: it strikes, the board says so, and navigates again afterwards.

Limits are for this drive, where the fault strikes at the beginning of a 90° turn; the measured figures stand
in docs/faults.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import pytest
from short_drive import DEGRADED, FAULT_AT_S, NAVIGATING, Drive, broken, drive

GOOD_M = 5.0
"""The receiver's own error here is up to 4 m."""
STEADY_M = 4.0


@dataclass(frozen=True)
class Case:
    """A fault, what the board must say of it, and what it may cost."""

    fault: str
    says: tuple[str, ...] = ()
    worst_m: float = STEADY_M
    """Largest error while navigating, from the fault to 60 s after."""
    good_after_s: float = 0.0
    """Time from the strike until the error stays below GOOD_M."""
    modes: frozenset[int] = frozenset({NAVIGATING})


LOST = frozenset({1, NAVIGATING, DEGRADED})
ALIGNS_AGAIN = frozenset({1, NAVIGATING})

CASES = {
    "chip missing, 0xFF": Case(
        broken("spi-missing", "imu", level=True),
        ("IMU nobody answers", "IMU answers again"),
        STEADY_M,
        13,
        ALIGNS_AGAIN,
    ),
    "chip missing, 0x00": Case(
        broken("spi-missing", "imu", level=False), ("IMU nobody answers",), STEADY_M, 13, ALIGNS_AGAIN
    ),
    "another chip": Case(
        broken("spi-register", "imu", register=0, value=0xD8), ("IMU wrong chip id",), STEADY_M, 13, LOST
    ),
    "SPI bit errors 1e-4": Case(
        broken("spi-bit-errors", "imu", duration_s=20.0, probability=1e-4), ("IMU samples missing",)
    ),
    "SPI bit errors 1e-3": Case(
        broken("spi-bit-errors", "imu", duration_s=20.0, probability=1e-3), ("IMU samples missing",)
    ),
    "SPI bit errors to the chip": Case(
        broken("spi-bit-errors", "imu", duration_s=20.0, probability=1e-3, line="mosi"), ("IMU",)
    ),
    "IMU reset": Case(broken("chip-reset", "U2", duration_s=None), ("IMU silent: restarted, ok",)),
    "IMU off": Case(broken("chip-off", "U2"), ("IMU silent", "IMU samples missing"), STEADY_M, 13, LOST),
    "gyro at the end of its range": Case(
        broken("sensor-saturated", "U2", duration_s=10.0),
        ("IMU out of range", "mode: degraded", "aligning again"),
        10.0,
        17,
        LOST,
    ),
    "gyro stuck at zero": Case(
        broken("sensor-stuck", "U2", duration_s=10.0),
        ("IMU frozen", "mode: degraded", "aligning again"),
        10.0,
        17,
        LOST,
    ),
    "gyro drifts away": Case(
        broken("sensor-drift", "U2", duration_s=10.0),
        ("GNSS refused", "mode: degraded", "aligning again"),
        150.0,
        20,
        LOST,
    ),
    "GNSS cable pulled": Case(
        broken("uart-cut", "gnss", duration_s=20.0), ("GNSS lost", "GNSS is back", "receiver: listening")
    ),
    "garbage": Case(
        broken("uart-garbage", "gnss", duration_s=None, length=20_000),
        ("receiver line disturbed", "GNSS lost"),
    ),
    "truncation": Case(
        broken("uart-truncation", "gnss", duration_s=15.0, keep=20), ("GNSS lost", "GNSS is back")
    ),
    "bit errors on the line": Case(
        broken("uart-bit-errors", "gnss", duration_s=20.0, probability=1e-3), ("receiver line disturbed",)
    ),
    "many bit errors on the line": Case(
        broken("uart-bit-errors", "gnss", duration_s=20.0, probability=1e-2), ("receiver line disturbed",)
    ),
    "stop bits found low": Case(
        broken("uart-framing-errors", "gnss", duration_s=10.0),
        ("receiver line disturbed", "receiver line is good again"),
    ),
    "parity": Case(
        broken("uart-parity", "gnss", duration_s=10.0),
        ("receiver line disturbed", "receiver line is good again"),
    ),
    "baud mismatch": Case(
        broken("uart-wrong-baud", "gnss", duration_s=20.0, baud=38_400), ("receiver line disturbed",)
    ),
    "GNSS an hour ahead": Case(
        broken("gnss-time-jump", "U3", duration_s=20.0, offset_s=3600.0), ("GNSS time has jumped",)
    ),
    "GNSS time back": Case(
        broken("gnss-time-jump", "U3", duration_s=20.0, offset_s=-2.5), ("GNSS time has jumped",)
    ),
    "GNSS time off for ever": Case(
        broken("gnss-time-jump", "U3", duration_s=None, offset_s=1.0), ("GNSS time has jumped",)
    ),
    "GNSS position off for 5 s": Case(broken("gnss-position-jump", "U3", north_m=100.0), ("GNSS refused",)),
    "GNSS position off for 20 s": Case(
        broken("gnss-position-jump", "U3", duration_s=20.0, north_m=100.0),
        ("GNSS refused", "GNSS believed again"),
        105,
        35,
    ),
    "receiver loses power": Case(
        broken("chip-off", "U3", duration_s=10.0),
        ("GNSS lost", "receiver: changing the bit rate", "receiver: running", "GNSS is back"),
    ),
    "receiver reset": Case(
        broken("chip-reset", "U3", duration_s=None), ("receiver: changing the bit rate", "receiver: running")
    ),
    "NaN from a kernel": Case(
        broken("nav-nan", "mcu", duration_s=None), ("state not a number",), STEADY_M, 13, ALIGNS_AGAIN
    ),
    "processor reset": Case(broken("cpu-reset", "mcu", duration_s=None), (), STEADY_M, 13, ALIGNS_AGAIN),
    "CAN disturbed": Case(broken("can-disturbance", "can1")),
    "card pulled": Case(
        broken("log-removed", "sdcard", duration_s=10.0), ("card: cannot be written", "card: writing")
    ),
}


@pytest.fixture(scope="module", params=CASES, ids=[name.replace(" ", "-") for name in CASES])
def outcome(request: pytest.FixtureRequest) -> tuple[Case, Drive]:
    case = CASES[request.param]
    return case, drive(case.fault)


def test_fault_strikes_is_told_and_is_survived(outcome: tuple[Case, Drive]) -> None:
    case, found = outcome
    assert found.result.faults[0].fired > 0
    for words in case.says:
        assert found.said(words, FAULT_AT_S - 1), found.texts()
    assert found.modes(FAULT_AT_S, FAULT_AT_S + 30) == case.modes
    finite = found.horizontal_error[found.t >= FAULT_AT_S]
    assert finite[finite < float("inf")].max() < case.worst_m
    assert found.good_after(GOOD_M, FAULT_AT_S) <= case.good_after_s
    assert found.worst(FAULT_AT_S + 45) < STEADY_M
    assert found.modes(FAULT_AT_S + 45) == {NAVIGATING}


def test_whole_drive_says_nothing_alarming() -> None:
    found = drive()
    assert [event.text for event in found.result.events] == [
        "mode: levelling",
        "receiver: changing the bit rate",
        "receiver: configuring",
        "receiver: running",
        "mode: waiting for heading",
        "mode: navigating",
    ]


@pytest.mark.parametrize("level", [True, False], ids=["0xFF", "0x00"])
def test_chip_that_comes_late_is_found_and_the_board_aligns(level: bool) -> None:
    found = drive(broken("spi-missing", "imu", 0.0, 60.0, level=level))
    assert found.said("IMU silent: restarted, nobody answers")
    assert found.said("IMU silent: restarted, ok", 59.0)
    assert found.worst(75.0) < STEADY_M


@pytest.mark.parametrize(
    "fault",
    [
        broken("spi-missing", "imu", 0.0, None, level=True),
        broken("spi-missing", "imu", 0.0, None, level=False),
        broken("spi-register", "imu", 0.0, None, register=0, value=0xD8),
        broken("chip-off", "U2", 0.0, None),
    ],
)
@pytest.mark.parametrize("profile", ["full-rate", "thesis"])
def test_board_without_its_sensor_runs_on_and_says_so(fault: str, profile: str) -> None:
    found = drive(fault, profile=profile)
    assert found.result.faults[0].fired > 0
    assert found.said("IMU")
    assert NAVIGATING not in found.modes()
    assert len(found.result.events) < 50
    assert found.result.cpu[0].resets == 0


def test_sensor_gone_for_good_leaves_degraded_solutions() -> None:
    found = drive(broken("chip-off", "U2", duration_s=None))
    assert DEGRADED in found.modes(FAULT_AT_S)
    assert NAVIGATING not in found.modes(FAULT_AT_S + 2)


def test_sigmas_tell_the_error_when_gnss_is_gone_for_good() -> None:
    """Two minutes and more of inertial navigation and vehicle constraints, with a stop on the way."""
    found = drive(broken("uart-cut", "gnss", duration_s=None))
    assert found.said("GNSS lost", FAULT_AT_S)
    sigma = (found.column("sigma_north_m") ** 2 + found.column("sigma_east_m") ** 2) ** 0.5
    alone = found.t > FAULT_AT_S
    assert (found.horizontal_error[alone] < 3 * sigma[alone]).all()
    assert found.horizontal_error[-1] < 30.0


@pytest.mark.parametrize("seed", [33, 37])
def test_two_spoilt_samples_in_a_row_are_not_believed(seed: int) -> None:
    """Bit errors that happen to strike two samples running, with jumps to different places."""
    found = drive(broken("spi-bit-errors", "imu", duration_s=20.0, probability=1e-3), seed=seed)
    assert found.said("IMU samples missing", FAULT_AT_S)
    assert found.worst(FAULT_AT_S) < GOOD_M


def test_reset_between_two_looks_of_the_host_keeps_the_times_of_both_lives() -> None:
    found = drive(broken("cpu-reset", "mcu", 110.0, None))
    t = found.t
    assert (t[1:] > t[:-1]).all()
    assert ((t > 100.0) & (t < 110.0)).sum() > 95
    assert found.worst(125.0) < STEADY_M


def test_faults_of_one_kind_and_target_have_names_and_randomness_of_their_own() -> None:
    one = broken("uart-bit-errors", "gnss", 20.0, 20.0, probability=1e-3).removeprefix("fault=[").rstrip("]")
    later = one.replace("at_s = 20.0", "at_s = 40.0")
    jump = broken("gnss-time-jump", "U3", 50.0, 3.0, offset_s=3600.0).removeprefix("fault=[").rstrip("]")
    longer = jump.replace("duration_s = 3.0", "duration_s = 5.0")
    found = drive("duration_s=61", f"fault=[{one}, {later}, {jump}, {longer}]")
    names = [fault.name for fault in found.result.faults]
    assert names == [
        *("uart-bit-errors gnss", "uart-bit-errors gnss 2"),
        *("gnss-time-jump U3", "gnss-time-jump U3 2"),
    ]
    flipped, flipped_later, jumped, jumped_longer = (fault.fired for fault in found.result.faults)
    assert flipped > 0
    assert flipped_later > 0
    assert (jumped, jumped_longer) == (3, 5)
