"""Rate from real accelerometers for minutes: what the filters know of its drift goes back into it."""

import numpy as np
import pytest
from packet_drive import accelerometer_words, packet_words

from firmware.nav import layout as at
from firmware.nav.gyro_free import layout as gl
from firmware.nav.gyro_free.config import GyroFreeConfig
from firmware.nav.gyro_free.filters import Federation, adxl345_filters, begin, new_federation
from firmware.nav.gyro_free.packet_door import FUSED, PacketDoor
from firmware.nav.gyro_free.rate_feedback import feed_rate_back
from host.tables.chapter5 import chapter5

DRIVE_S = 60
DRIFT = 0.02
"""m/s² of one accelerometer: ω̇ is off by 2.3 °/s each second, a rate of 2.3 °/s more every second."""
FELT = np.zeros(7, np.float32)


def driven(method: str) -> tuple[Federation, np.ndarray, float]:
    """The federation, its headings after each fusion, the largest rate it ever had to carry."""
    feed = chapter5(DRIVE_S, 3)
    offsets = np.zeros(9)
    offsets[0] = DRIFT
    accelerations = accelerometer_words(feed, 3, offsets)
    config = adxl345_filters(GyroFreeConfig(method=method))
    federation = new_federation(config)
    begin(federation, config, feed.start)
    door = PacketDoor(federation)
    headings, largest = [], 0.0
    for sample in range(DRIVE_S * 200):
        done = door.take(packet_words(feed, sample, accelerations), FELT)
        if done & FUSED:
            w, x, y, z = federation.master[0][at.QUATERNION : at.QUATERNION + 4].astype(float)
            headings.append(np.degrees(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))))
            largest = max(largest, float(np.max(np.abs(federation.g[gl.INTEGRAL : gl.INTEGRAL + 3]))))
    return federation, np.array(headings), np.degrees(largest)


@pytest.fixture(scope="module")
def runs() -> dict[str, tuple[Federation, np.ndarray, float]]:
    return {method: driven(method) for method in gl.METHOD_NAMES}


@pytest.mark.parametrize("method", gl.METHOD_NAMES)
def test_every_method_holds_heading_on_a_drifting_rate(runs, method: str) -> None:  # type: ignore[no-untyped-def]
    federation, headings, largest = runs[method]
    assert not federation.n[gl.ISOLATIONS : gl.ISOLATIONS + 2].any()
    # without feedback the integral is some 130 °/s off after a minute of it
    assert largest < 15.0
    late = headings[len(headings) // 3 :] - 30.0
    assert np.sqrt(np.mean(late**2)) < 1.5
    assert np.max(np.abs(late)) < 4.0


def test_a_feedback_changes_no_rate_that_a_filter_sees(runs) -> None:  # type: ignore[no-untyped-def]
    g = runs["fused"][0].g.copy()
    pairs = [f.copy() for f in runs["fused"][0].all[::2]]
    g[gl.RATE_MATRIX : gl.RATE_MATRIX + 9] = (1.01, 0.02, 0.0, -0.01, 0.99, 0.03, 0.0, 0.01, 1.0)
    for k, f in enumerate(pairs):
        f[at.GYRO_BIAS : at.GYRO_BIAS + 3] = (0.3, -0.2, 0.1 + 0.05 * k)

    def seen() -> np.ndarray:
        rate = g[gl.RATE_MATRIX : gl.RATE_MATRIX + 9].reshape(3, 3) @ g[gl.METHOD_RATE : gl.METHOD_RATE + 3]
        return np.array([rate - f[at.GYRO_BIAS : at.GYRO_BIAS + 3] for f in pairs])

    before = seen()
    feed_rate_back(g, *pairs)
    assert seen() == pytest.approx(before, abs=1e-6)
    assert np.max(np.abs(pairs[2][at.GYRO_BIAS : at.GYRO_BIAS + 3])) < 0.03
