"""Defects that every chip model can be given: another identity, a clock that is off, a world that changed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from boards.chips.adis16407 import Adis16407
from boards.chips.adxl345 import Adxl345
from boards.chips.bmi160 import Bmi160
from boards.chips.hmc6343 import Hmc6343
from boards.sense import Defect, Drift, Frozen, Saturated, Sense, Stuck
from hal.emulated.pins import Net
from hal.emulated.virtual_time import VirtualTime

MS, SECOND = 1_000_000, 1_000_000_000
G = 9.80665
COLUMNS = {Adis16407: 11, Adxl345: 7, Bmi160: 7, Hmc6343: 7}


class Constant:
    """The same values for ever, noted when asked for."""

    def __init__(self, columns: int) -> None:
        self.values = np.zeros(columns)
        self.values[2] = G
        self.values[10:] = 100_000.0

    def sample(self, times_ns: Any, *bandwidth_hz: float) -> Any:
        return np.tile(self.values, (len(times_ns), 1))


class Bench:
    """A chip that samples, with data ready on a net whose rising edges are noted."""

    def __init__(self, model: Any) -> None:
        self.time = VirtualTime()
        self.world = Constant(COLUMNS[model])
        self.sense = Sense(self.world)
        self.chip = model(self.time, self.sense)
        self.rises: list[int] = []
        net = Net(self.time, "ready")
        self.chip.pins[READY[model]] = net
        net.listen(lambda level, time_ns: self.rises.append(time_ns) if level else None)
        SETUPS[model](self)

    def wait(self, duration_ns: int) -> None:
        end = self.time.now + duration_ns
        while self.time.next_due <= end:
            self.time.run_next()
        self.time.now = end

    def spi(self, mosi: bytes, byte_ns: int = 8_000) -> bytes:
        start = self.time.now
        miso = bytes(self.chip.transaction(mosi, start, start + len(mosi) * byte_ns))
        self.wait(len(mosi) * byte_ns + 30_000)
        return miso


def set_up_adxl345(bench: Bench) -> None:
    for write in (b"\x31\x0b", b"\x2c\x0a", b"\x2e\x80", b"\x2d\x08"):  # ±16 g full, 100 Hz, data ready, on
        bench.spi(write)


def set_up_bmi160(bench: Bench) -> None:
    bench.wait(10 * MS)
    bench.spi(b"\x80\x00")
    for write in (b"\x7e\x11", b"\x7e\x15", b"\x51\x10", b"\x53\x0a", b"\x56\x80"):
        bench.spi(write)
        bench.wait(100 * MS)


def set_up_hmc6343(bench: Bench) -> None:
    bench.wait(600 * MS)


def set_up_adis16407(bench: Bench) -> None:
    bench.wait(250 * MS)


SETUPS: dict[Any, Callable[[Bench], None]] = {
    Adxl345: set_up_adxl345,
    Bmi160: set_up_bmi160,
    Hmc6343: set_up_hmc6343,
    Adis16407: set_up_adis16407,
}
READY = {Adxl345: "INT1", Bmi160: "INT1", Hmc6343: "DRDY", Adis16407: "DIO1"}


def identity(bench: Bench) -> int:
    """As a driver asks for it."""
    chip = bench.chip
    if isinstance(chip, Adis16407):
        bench.spi(b"\x56\x00")
        return int.from_bytes(bench.spi(b"\x56\x00"), "big")
    if isinstance(chip, Hmc6343):
        assert chip.i2c.write(b"\xe1\x00", bench.time.now) == 2
        bench.wait(11 * MS)
        return chip.i2c.read(1, bench.time.now)[0]
    return bench.spi(b"\x80\x00")[1]


def level(bench: Bench) -> int:
    """The accelerometer's z, in counts."""
    chip = bench.chip
    if isinstance(chip, Adis16407):
        bench.spi(b"\x0e\x00")
        return (int.from_bytes(bench.spi(b"\x0e\x00"), "big") & 0x3FFF ^ 0x2000) - 0x2000
    if isinstance(chip, Hmc6343):
        chip.i2c.write(b"\x40", bench.time.now)
        bench.wait(2 * MS)
        return int.from_bytes(chip.i2c.read(6, bench.time.now)[4:], "big", signed=True)
    if isinstance(chip, Adxl345):
        return int.from_bytes(bench.spi(b"\xf2" + bytes(6), 1_600)[5:7], "little", signed=True)
    return int.from_bytes(bench.spi(b"\x96\x00\x00")[1:3], "little", signed=True)


MODELS = [Adis16407, Adxl345, Bmi160, Hmc6343]


@pytest.mark.parametrize("model", MODELS)
def test_another_identity_and_its_own_again(model: Any) -> None:
    bench = Bench(model)
    own = identity(bench)
    bench.chip.pretend_id(0x5A)
    assert identity(bench) == 0x5A
    bench.chip.power(False)
    bench.chip.power(True)
    bench.wait(SECOND)
    if model is Bmi160:
        bench.spi(b"\x80\x00")
    assert identity(bench) == 0x5A, "whatever its supply does"
    bench.chip.pretend_id(None)
    assert identity(bench) == own


@pytest.mark.parametrize("ppm", [-50_000.0, 50_000.0])
@pytest.mark.parametrize("model", MODELS)
def test_a_clock_that_is_off_from_now_on(model: Any, ppm: float) -> None:
    bench = Bench(model)
    read_each_sample(bench, 3 * SECOND)
    usual = np.diff(bench.rises)[2:]
    assert np.ptp(usual) <= 1 or model is Adis16407, "an even clock"
    before = bench.rises[-1]
    bench.chip.set_clock_error(ppm)
    bench.rises.clear()
    read_each_sample(bench, 3 * SECOND)
    spacing = np.diff(bench.rises)
    assert 0 < bench.rises[0] - before <= 2 * usual.max(), "none is lost, none comes twice"
    assert spacing[1:].mean() == pytest.approx(usual.mean() / (1 + ppm * 1e-6), rel=2e-4)
    bench.chip.set_clock_error(0.0)
    bench.rises.clear()
    read_each_sample(bench, 2 * SECOND)
    assert np.diff(bench.rises)[1:].mean() == pytest.approx(usual.mean(), rel=2e-4)


def read_each_sample(bench: Bench, duration_ns: int) -> None:
    """Let time pass; the reader of chips whose data ready a read takes back looks at each rise."""
    end = bench.time.now + duration_ns
    seen = len(bench.rises)
    while bench.time.now < end:
        bench.wait(MS)
        if len(bench.rises) > seen and isinstance(bench.chip, Adxl345):
            level(bench)
        seen = len(bench.rises)


@pytest.mark.parametrize("model", MODELS)
def test_looking_anew_shows_what_changed(model: Any) -> None:
    bench = Bench(model)
    bench.wait(2 * SECOND)
    usual = level(bench)
    bench.world.values[2] = -G
    if hasattr(bench.chip, "look_anew"):
        bench.chip.look_anew()
    bench.wait(250 * MS)
    assert level(bench) == pytest.approx(-usual, abs=1)


@pytest.mark.parametrize("model", MODELS)
def test_a_saturated_element_shows_the_end_of_the_range(model: Any) -> None:
    bench = Bench(model)
    bench.sense.defects.append(Saturated(0, 1 << 62, ("accel",), "z"))
    if hasattr(bench.chip, "look_anew"):
        bench.chip.look_anew()
    bench.wait(400 * MS)
    assert level(bench) == {Adis16407: 8191, Adxl345: 4095, Bmi160: 32767, Hmc6343: 32767}[model]


def test_adis16407_with_its_sample_clock_standing_still() -> None:
    bench = Bench(Adis16407)
    bench.wait(100 * MS)
    burst = b"\x42" + bytes(29)
    assert bench.spi(burst)[2] & 0x80, "new data"
    bench.chip.halt(True)
    bench.wait(5 * MS)
    bench.spi(burst)
    for _ in range(3):
        bench.wait(5 * MS)
        stale = bench.spi(burst)
        assert [stale[k] & 0x80 for k in range(2, 30, 2)] == [0] * 14
    edges = len(bench.rises)
    bench.wait(50 * MS)
    assert len(bench.rises) == edges, "no data ready"
    bench.chip.halt(False)
    bench.wait(5 * MS)
    assert bench.spi(burst)[2] & 0x80
    assert len(bench.rises) > edges


def test_adis16407_raises_flags_with_every_sample() -> None:
    bench = Bench(Adis16407)
    burst = b"\x42" + bytes(29)
    bench.chip.raise_flags(0x0020)
    for _ in range(3):
        bench.wait(5 * MS)
        assert bench.spi(burst)[2] & 0x40, "EA"
        bench.spi(b"\x40\x00")
        assert int.from_bytes(bench.spi(b"\x40\x00"), "big") in (0x0020, 0)
    bench.chip.raise_flags(0)
    bench.spi(b"\x40\x00")
    bench.wait(5 * MS)
    assert not bench.spi(burst)[2] & 0x40


# -- sensor elements -------------------------------------------------------------------------------


def samples(defect: Defect, columns: int = 11) -> Any:
    """Ten samples, one a second, of a world whose columns count up; the defect from 3 s to 6 s."""
    times = np.arange(10) * SECOND

    class Rising:
        def sample(self, times_ns: Any, *bandwidth_hz: float) -> Any:
            return times_ns[:, None] * 1e-9 + np.arange(columns) * 100.0

    sense = Sense(Rising())
    sense.defects.append(defect)
    first, second = sense.sample(times[:5], 100.0), sense.sample(times[5:], 100.0)
    return np.vstack((first, second)), times[:, None] * 1e-9 + np.arange(columns) * 100.0


def test_frozen() -> None:
    defect = Frozen(3 * SECOND, 6 * SECOND, ("gyro", "pressure"))
    got, usual = samples(defect)
    expected = usual.copy()
    expected[3:6, [3, 4, 5, 10]] = usual[3, [3, 4, 5, 10]]
    assert np.array_equal(got, expected)
    assert defect.fired == 3


def test_stuck_saturated_drift_on_one_axis() -> None:
    got, usual = samples(Stuck(3 * SECOND, 6 * SECOND, ("mag",), "y", value=5e-5))
    assert np.array_equal(np.flatnonzero((got != usual).any(axis=0)), [8])
    assert (got[3:6, 8] == 5e-5).all()
    got, usual = samples(Saturated(3 * SECOND, 6 * SECOND, ("accel",), "z", negative=True))
    assert (got[3:6, 2] < -1e3).all()
    got, usual = samples(Drift(3 * SECOND, 6 * SECOND, ("gyro",), "x", rate=0.5))
    assert np.allclose(got[3:6, 3] - usual[3:6, 3], [0.0, 0.5, 1.0])
    assert np.array_equal(got[6:], usual[6:])


def test_a_compass_has_its_field_where_others_have_their_rate() -> None:
    got, usual = samples(Stuck(3 * SECOND, 6 * SECOND, ("mag",), "x", value=0.0), columns=7)
    assert np.array_equal(np.flatnonzero((got != usual).any(axis=0)), [3])


def test_an_axis_that_is_none() -> None:
    with pytest.raises(ValueError, match="axis 'w'"):
        Stuck(0, 1, ("gyro",), "w")
