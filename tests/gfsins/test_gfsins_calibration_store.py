"""What calibration has found survives power cuts, and only what is whole is used."""

from __future__ import annotations

import contextlib
import struct

import numpy as np
import pytest

from firmware.apps.gfsins import calibration as cal
from firmware.apps.gfsins.calibration import Calibration
from firmware.apps.gfsins.calibration_store import CalibrationStore, Found
from firmware.apps.gfsins.coefficients import COUNT, FIRST_WORD, Coefficients, packet_words
from firmware.apps.gfsins.corrections import Corrections
from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free import packet as pk
from firmware.nav.gyro_free.config import GyroFreeConfig, new_sensor
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.flash import EmulatedFlash
from hal.emulated.virtual_time import VirtualTime
from hal.endings import PowerOff

DEVIATION = (0.02, -0.1, 0.07, -0.03, 0.01, *[0.001] * 5)
OLD, NEW = {1: struct.pack(">2f", 1.0, 2.0)}, {1: struct.pack(">2f", 3.0, 4.0), 9: b""}


def flash() -> EmulatedFlash:
    return EmulatedFlash(EmulatedCpu(VirtualTime(), "fpga", 70_000_000), "calibration")


def accelerometers() -> tuple[float, ...]:
    """Nine responses and offsets, and a matrix of the origin."""
    axes = [(1.0 + 0.004 * (k - 4), 0.001, -0.001, 0.1 * (k - 4), 1e-4, 1e-3) for k in range(9)]
    return (*(x for axis in axes for x in axis), 1.0, 0.002, 0.0, 0.0, 1.0, -0.001, 0.003, 0.0, 1.0)


def test_a_power_cut_at_any_instant_leaves_the_old_or_the_new() -> None:
    whole = flash()
    assert CalibrationStore(whole).save(OLD)
    seen = set()
    for cut_us in range(500, 22_000, 1_500):
        cpu = EmulatedCpu(VirtualTime(), "fpga", 70_000_000)
        torn = EmulatedFlash(cpu, "calibration")
        torn.load(whole.content)
        store = CalibrationStore(torn)
        assert store.load() == OLD
        cpu.time.at(cut_us * 1000, cut)
        with contextlib.suppress(PowerOff):
            assert store.save(NEW)
        again = CalibrationStore(loaded(torn.content))
        found = again.load()
        assert again.found is Found.GOOD
        assert found in (OLD, NEW)
        seen.add(len(found))
        assert again.save(NEW), "and it can be written after that"
        assert CalibrationStore(loaded(torn.content)).load() in (OLD, NEW)
    assert seen == {1, 2}, "both were met"


def cut() -> None:
    raise PowerOff


def loaded(content: bytes) -> EmulatedFlash:
    memory = flash()
    memory.load(content)
    return memory


def test_the_newest_counts_through_many_writes() -> None:
    memory = flash()
    store = CalibrationStore(memory)
    for k in range(5):
        assert store.save({2: struct.pack(">f", float(k))})
    assert CalibrationStore(memory).load() == {2: struct.pack(">f", 4.0)}
    assert memory.erasures == 5


@pytest.mark.parametrize(
    ("content", "found"),
    [
        (b"\xff" * 4224, Found.NOTHING),
        (bytes(4224), Found.SPOILT),
        (bytes(range(256)) * 16 + bytes(128), Found.SPOILT),
    ],
)
def test_what_is_not_ours_is_not_used(content: bytes, found: Found) -> None:
    held = Calibration(loaded(content), Corrections())
    held.load()
    assert held.found is found
    assert held.corrections.scales.tolist() == [512_000] * 9
    words = held.packet_words()
    assert (words is None) == (found is Found.NOTHING)
    sensor = Coefficients(new_sensor(GyroFreeConfig())[0])
    if words is not None:
        packet = np.zeros(pk.WORDS, np.int64)
        packet[FIRST_WORD : FIRST_WORD + 4] = words[0]
        assert sensor.take(packet), "nothing is waited for"
        assert sensor.is_spoilt
    assert not sensor.is_used


def test_one_wrong_bit_is_found_wherever_it_is() -> None:
    memory = flash()
    held = Calibration(memory, Corrections())
    held.load()
    assert held.keep({cal.DEVIATION: DEVIATION})
    length = len(memory.content.rstrip(b"\xff")) + 2
    for place in range(0, length - 2, 7):
        spoilt = bytearray(memory.content)
        spoilt[place] ^= 1 << place % 8
        again = Calibration(loaded(bytes(spoilt)), Corrections())
        again.load()
        assert again.found is Found.SPOILT, place


def test_numbers_that_are_none_or_beyond_all_limits_are_not_used() -> None:
    for tag, data in (
        (cal.DEVIATION, struct.pack(">10f", *[float("nan")] * 10)),
        (cal.DEVIATION, struct.pack(">9f", *[0.1] * 9)),
        (cal.CORRECTIONS, cal.WHOLE.pack(*[512_000] * 8, 5, *[0] * 9)),
        (77, struct.pack(">f", 1.0)),
    ):
        memory = flash()
        assert CalibrationStore(memory).save({tag: data})
        held = Calibration(memory, Corrections())
        held.load()
        assert held.found is Found.SPOILT
        assert held.deviation == (0.0,) * 5
        assert held.corrections.scales.tolist() == [512_000] * 9


def test_coefficients_arrive_whatever_packets_are_lost() -> None:
    memory = flash()
    held = Calibration(memory, Corrections())
    held.load()
    assert held.keep({cal.ACCELEROMETERS: accelerometers()})
    assert held.keep({cal.DEVIATION: DEVIATION})
    words = Calibration(memory, Corrections())
    words.load()
    rows = words.packet_words()
    assert rows is not None
    assert len(rows) == COUNT
    g, _ = new_sensor(GyroFreeConfig())
    sensor = Coefficients(g)
    rng = np.random.default_rng(5)
    waited = 0
    for k in range(10 * COUNT):
        if rng.random() < 0.5:
            continue
        packet = np.zeros(pk.WORDS, np.int64)
        packet[FIRST_WORD : FIRST_WORD + 4] = rows[k % COUNT]
        if sensor.take(packet):
            break
        waited += 1
    assert sensor.is_used
    assert waited > COUNT / 2
    assert g[gl.COMPASS_DEVIATION : gl.COMPASS_DEVIATION + 5] == pytest.approx(DEVIATION[:5])
    assert g[gl.FORCE_MATRIX : gl.FORCE_MATRIX + 9] == pytest.approx(accelerometers()[54:])
    # scale and offset in whole numbers and what they leave make the reading right
    for k, (own, _, _, offset) in enumerate(np.array(accelerometers()[:54]).reshape(9, 6)[:, :4].tolist()):
        force = 5.0
        counts = (own * force + offset) / (9.80665 / 256.0)
        packet_words = counts * int(words.corrections.scales[k]) / 65536 - int(words.corrections.offsets[k])
        assert packet_words * 0.5e-3 * 9.80665 - g[gl.OFFSET + k] == pytest.approx(force, abs=2e-5)


def test_coefficients_of_a_later_calibration_take_the_place_of_those_before() -> None:
    g, _ = new_sensor(GyroFreeConfig())
    sensor = Coefficients(g)
    for generation, value in ((1, 0.25), (2, 0.5)):
        rows = packet_words([value] * COUNT, generation)
        taken = []
        for row in (*rows, *rows):
            packet = np.zeros(pk.WORDS, np.int64)
            packet[FIRST_WORD : FIRST_WORD + 4] = row
            taken.append(sensor.take(packet))
        assert taken == [False] * (COUNT - 1) + [True] * (COUNT + 1)
        assert g[gl.COMPASS_DEVIATION + 4] == value


def test_new_accelerometers_make_what_was_found_with_the_old_ones_void() -> None:
    held = Calibration(flash(), Corrections())
    held.load()
    assert held.keep({cal.RATES: (1.1, 0.0, 0.0, 0.0, 1.1, 0.0, 0.0, 0.0, 1.1, *[0.0] * 3, *[0.01] * 12)})
    assert held.rate_matrix()[0] == pytest.approx(1.1)
    assert held.keep({cal.ACCELEROMETERS: accelerometers()})
    assert held.rate_matrix()[0] == 1.0
    assert held.values(cal.RATES) == ()


def test_a_memory_that_is_worn_out_leaves_all_as_it_was() -> None:
    memory = flash()
    held = Calibration(memory, Corrections())
    held.load()
    assert held.keep({cal.ACCELEROMETERS: accelerometers()})
    before = held.corrections.scales.tolist(), held.corrections.offsets.tolist()
    memory.failed = True
    rest = {cal.ALIGNMENT: (0.1, 0.0, 0.0, *[0.1] * 6)}
    for _ in range(2):
        assert not held.keep(rest)
        assert (held.corrections.scales.tolist(), held.corrections.offsets.tolist()) == before
        assert held.values(cal.ALIGNMENT) == ()
    memory.failed = False
    assert held.keep(rest)
    assert held.corrections.offsets[0] == before[1][0] + 20


@pytest.mark.parametrize(("response", "offset_mg", "fits"), [(0.8690, 0, 0), (0.8700, 0, 1), (0.9, 370, 0)])
def test_nothing_is_kept_of_what_cannot_be_corrected(response: float, offset_mg: float, fits: int) -> None:
    """A scale of 1.15 and 400 mg at most, of what is divided by the response."""
    held = Calibration(flash(), Corrections())
    held.load()
    axes = [(response, 0.0, 0.0, offset_mg * 9.80665e-3, 1e-4, 1e-3)] * 9
    found = {cal.ACCELEROMETERS: (*(x for axis in axes for x in axis), *cal.IDENTITY)}
    assert held.can_correct(found) == held.keep(found) == bool(fits)
    assert (held.corrections.scales.tolist() == [512_000] * 9) == (not fits)
    assert bool(held.values(cal.ACCELEROMETERS)) == bool(fits)


def test_elements_of_the_rates_within_five_sigmas_stay_nominal() -> None:
    held = Calibration(flash(), Corrections())
    held.load()
    rates = (1.04, 0.0, -0.06, 0.0, 1.06, 0.0, 0.0, 0.0, 1.02, *[0.0] * 3, *[0.01] * 12)
    assert held.keep({cal.RATES: rates})
    assert held.rate_matrix() == pytest.approx([1.0, 0.0, -0.06, 0.0, 1.06, 0.0, 0.0, 0.0, 1.0])
