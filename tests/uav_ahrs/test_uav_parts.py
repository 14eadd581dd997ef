"""Parts of the program by themselves: settings, SPI registers, the sample clock, jumps, measurements."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some
from uav_runs import fly

from boards.description import load_board
from firmware.apps.uav_ahrs import plausibility as memory
from firmware.apps.uav_ahrs.measured import ambient
from firmware.apps.uav_ahrs.sample_phase import NOMINAL_PERIOD, SamplePhase
from firmware.apps.uav_ahrs.startup import SPI_A, STEPS, initialise
from firmware.nav.attitude.flags import METHOD_NAMES
from host.record.errors import UserError
from host.record.result import RunRequest
from host.run.runner import check

HASHES: set[str] = set()


def test_spi_registers_are_the_documents_and_those_of_the_wire() -> None:
    assert (SPI_A.spiccr, SPI_A.spictl, SPI_A.spibrr, SPI_A.spipri) == (0x00CF, 0x0007, 49, 0x0020)
    bus = load_board("uav_ahrs").buses["spia"]
    assert SPI_A.bit_rate_hz == bus.clock_hz == 750_000
    assert SPI_A.mode == bus.mode == 3
    assert SPI_A.bits_per_word == 16
    assert SPI_A.is_master


def test_initialisation_keeps_the_documents_order() -> None:
    class Cpu:
        def __init__(self) -> None:
            self.done: list[str] = []

        def cost(self, work: str) -> int:
            self.done.append(work)
            return 1

        def spend(self, cycles: int) -> None:
            assert cycles == 1

    cpu = Cpu()
    initialise(cpu)  # type: ignore[arg-type]
    order = ["system_control", "interrupts_off", "pie_control", "pie_vectors", "spi_gpio", "spi_registers"]
    assert cpu.done == order == list(STEPS)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("arithmetic=float16", "profile key arithmetic = 'float16' is not possible; choose one of 'float32'"),
        ("update=rk5", "profile key update = 'rk5' is not possible; choose one of 'rk4'"),
        ("drift_compensation=1", "profile key drift_compensation = 1 is not possible"),
        ("output_rate_hz=7", "profile key output_rate_hz = 7 is not possible; choose one of 1, 5, 25, 125"),
        ("latitude_deg=91.0", "profile key latitude_deg = 91.0 is no number from -89 to 89"),
        ("initial_yaw_deg=360.0", "profile key initial_yaw_deg = 360.0 is no number from 0 to 360"),
        ("alignment_s=nan", "profile key alignment_s = nan is no number from 0.5 to 60"),
        ("magnetometer=false", "magnetometer = false: nothing tells the heading at the start"),
        ("speed=1", "profile key 'speed' (value 1) is unknown; known keys: alignment_s, arithmetic"),
    ],
)
def test_impossible_profiles_are_told_in_one_message(change: str, message: str) -> None:
    with pytest.raises(UserError) as error:
        check(RunRequest("uav_ahrs", "static", overrides=(f"profile.{change}",)))
    assert message in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("update", METHOD_NAMES)
def test_every_update_is_a_choice_of_its_own(update: str) -> None:
    """At rest all of them agree with the truth; none is the same arithmetic."""
    flown = fly("static", "document", "duration_s=8", f"profile.update={update}", "expect={}")
    assert flown.worst_deg(6.0, 8.0) < 2.0
    HASHES.add(flown.result.state_hash)
    assert len(HASHES) == METHOD_NAMES.index(update) + 1


@given(
    ppm=some.integers(-20_000, 20_000),
    first_ns=some.integers(0, 2_000_000_000),
    late_ns=some.lists(some.integers(-15_000, 15_000), min_size=40, max_size=40),
)
def test_the_sample_clock_is_found(ppm: int, first_ns: int, late_ns: list[int]) -> None:
    """Instants as looks find them, each off by up to 15 µs, of a clock that is off by up to 2 %."""
    period = 1e9 / 819.2 / (1 + ppm * 1e-6)
    phase = SamplePhase()
    now = first_ns
    for late in late_ns:
        now = max(now + 4_000_000, phase.next_look_ns)
        n = np.ceil((now - first_ns) / period)
        phase.renewed(round(first_ns + n * period) + late)
        now = round(first_ns + n * period)
    assert phase.is_settled
    assert phase.error_ppm == pytest.approx(ppm, abs=25)
    read = now + 3_333_333
    age = (read - first_ns) % period
    off = abs(phase.age_ns(read) - age)
    assert min(off, period - off) < 40_000


def test_a_clock_that_changes_is_found_again() -> None:
    phase = SamplePhase()
    now, period = 0.0, 1e9 / 819.2
    for _ in range(12):
        now = (max(now + 4e6, phase.next_look_ns) // period + 1) * period
        phase.renewed(round(now))
    assert abs(phase.error_ppm) < 5
    begin, period = now, 1e9 / 819.2 / 1.02
    for _ in range(14):
        now = begin + ((max(now + 4e6, phase.next_look_ns) - begin) // period + 1) * period
        phase.renewed(round(now))
    assert phase.error_ppm == pytest.approx(20_000, abs=20)
    assert phase.period < NOMINAL_PERIOD


def words(rate: int = 0, force: int = 0) -> np.ndarray:
    found = np.full(14, 0x8000, np.int64)
    found[1] |= rate & 0x3FFF
    found[4] |= force & 0x3FFF
    return found


def test_a_jump_is_refused_until_the_next_burst_says_the_same() -> None:
    k = np.zeros(memory.PLAUSIBILITY_SIZE, np.int64)
    assert not memory.is_jump(k, words(10), False)
    assert memory.is_jump(k, words(4000), False)
    assert not memory.is_jump(k, words(12), False)
    assert memory.is_jump(k, words(4000), False)
    assert not memory.is_jump(k, words(4010), False)
    assert k[memory.JUMPS] == 2


def test_rates_that_jump_to_the_end_of_their_range_are_never_believed() -> None:
    """The burst is, after ten refused; its rates stay those before until they are in range again."""
    k = np.zeros(memory.PLAUSIBILITY_SIZE, np.int64)
    assert not memory.is_jump(k, words(10, 300), False)
    for n in range(500):
        burst = words(0x1770, 310)
        assert memory.is_jump(k, burst, True) == (n < 10)
        assert n < 10 or burst[1] & 0x3FFF == 10
    assert k[memory.RATES_ROW] == 500
    assert k[memory.LAST + 4] & 0x3FFF == 310
    assert not memory.is_jump(k, words(20, 310), False)
    assert k[memory.RATES_ROW] == 0


def test_rates_that_went_to_the_end_of_their_range_are_believed() -> None:
    k = np.zeros(memory.PLAUSIBILITY_SIZE, np.int64)
    for rate in [*range(0, 6000, 400), *[6000] * 50]:
        burst = words(rate)
        assert not memory.is_jump(k, burst, rate >= 6000)
        assert burst[1] & 0x3FFF == rate


@given(some.lists(some.integers(-400, 400), min_size=1, max_size=60))
def test_what_a_body_can_do_is_never_refused(steps: list[int]) -> None:
    k = np.zeros(memory.PLAUSIBILITY_SIZE, np.int64)
    rate = 0
    for step in steps:
        rate = max(-6500, min(6500, rate + step))
        assert not memory.is_jump(k, words(rate), abs(rate) >= 6000)


def test_measurements_of_the_fact_sheet() -> None:
    burst = [
        0xC7A7,
        *[0x8000] * 6,
        0x8000 | 300,
        0x8000 | 400,
        0x8000,
        0x8000 | 0x30D4,
        0x8000,
        0x804A,
        0x8000,
    ]
    supply_mv, temperature, pressure_pa, field_nt, _adc = ambient(burst)
    assert supply_mv == 4736  # 0x7A7 steps of 2.418 mV
    assert temperature == 2500 + 74 * 136 // 10  # 35 degrees and a little
    assert pressure_pa == 100_000
    assert field_nt == 500 * 50
