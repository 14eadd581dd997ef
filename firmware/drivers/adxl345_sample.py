"""From the ADXL345's six data bytes to SI units: pure conversion in the kernel dialect.

A sample as it lies in the driver's buffer: byte 0 is the address byte's slot, then x, y, z (16 bits each,
low byte first, right-justified); fact sheet section 3.

    f = count · g / (LSB per g)
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from firmware.drivers.signed_words import signed_16
from firmware.numerics.dialect import kernel

SAMPLE_LENGTH: Final = 7
"""Address byte and the six registers from DATAX0 to DATAZ1."""

STANDARD_GRAVITY: Final = 9.80665
LSB_PER_G: Final = 256.0
"""Full resolution, whatever the range (nominal; 230 … 282)."""

FORCE_SIZE: Final = 3
"""A converted sample: f x, y, z in m/s², sensor axes."""


def scale(lsb_per_g: float = LSB_PER_G) -> NDArray[np.float32]:
    """(m/s² per LSB) for `convert`; another sensitivity than the nominal one comes from calibration."""
    return np.array([STANDARD_GRAVITY / lsb_per_g], np.float32)


@kernel
def force(raw, unit):
    """(f x, y, z) of a sample, with the unit of a count."""
    return (
        signed_16(raw[1], raw[2]) * unit,
        signed_16(raw[3], raw[4]) * unit,
        signed_16(raw[5], raw[6]) * unit,
    )


@kernel("int64(uint8[::1], float32[::1], float32[::1])")
def convert(raw, unit, sample):
    """Fill `sample` (FORCE_SIZE) from a sample's bytes. Returns 0."""
    fx, fy, fz = force(raw, unit[0])
    sample[0] = fx
    sample[1] = fy
    sample[2] = fz
    return np.int64(0)
