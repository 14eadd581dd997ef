"""Number fields of a sentence, in integer arithmetic (fact sheet section 2).

Every value is first rounded to an integer number of its last printed digit and then taken apart, so that
a carry runs through (59.999999 minutes become the next degree, never 60.00000), a value that rounds to
zero has no sign, and 359.996° is 0.00°.
"""

import math

_DEGREES = 180.0 / math.pi
_MINUTE_UNITS = 6_000_000
"""1e-5 minutes in a degree."""
_FINE_UNITS = 600_000_000
"""1e-7 minutes in a degree (high precision mode)."""
LARGEST_ACCURACY = 9_999_999.0
_ENDINGS = [b"*%02X\r\n" % value for value in range(256)]


def degrees(radians: float) -> float:
    """Radians to degrees."""
    return radians * _DEGREES


def longitude_degrees(radians: float) -> float:
    """A longitude in degrees within [−180, 180]."""
    value = radians * _DEGREES
    if -180.0 <= value <= 180.0:
        return value
    return (value + 180.0) % 360.0 - 180.0


def position(latitude_deg: float, longitude_deg: float, fine: bool = False) -> bytes:
    """The four fields latitude, N/S, longitude, E/W: five decimals of minutes, seven when `fine`."""
    units = _FINE_UNITS if fine else _MINUTE_UNITS
    lat = int(abs(latitude_deg) * units + 0.5)
    lon = int(abs(longitude_deg) * units + 0.5)
    lat = min(lat, 90 * units)
    lon = min(lon, 180 * units)
    north = b"S" if latitude_deg < 0.0 and lat else b"N"
    east = b"W" if longitude_deg < 0.0 and lon else b"E"
    lat_deg, lat_min = divmod(lat, units)
    lon_deg, lon_min = divmod(lon, units)
    if fine:
        return b"%02d%02d.%07d,%b,%03d%02d.%07d,%b" % (
            *(lat_deg, *divmod(lat_min, 10_000_000), north),
            *(lon_deg, *divmod(lon_min, 10_000_000), east),
        )
    return b"%02d%02d.%05d,%b,%03d%02d.%05d,%b" % (
        lat_deg,
        lat_min // 100_000,
        lat_min % 100_000,
        north,
        lon_deg,
        lon_min // 100_000,
        lon_min % 100_000,
        east,
    )


def decimal(value: float, decimals: int) -> bytes:
    """A signed number with 1 to 3 decimals; never −0.0."""
    scale = 10**decimals
    units = int(abs(value) * scale + 0.5)
    sign = b"-" if value < 0.0 and units else b""
    return b"%b%d.%0*d" % (sign, units // scale, decimals, units % scale)


def course(course_deg: float) -> bytes:
    """A course in [0, 360)° with two decimals."""
    units = int(course_deg * 100.0 + 0.5) % 36_000
    return b"%d.%02d" % (units // 100, units % 100)


def two_figures(value: float) -> bytes:
    """An accuracy as the receiver writes it: two significant figures below 10 (0.46, 1.2), then whole."""
    if value < 0.995:
        return b"%.2f" % value
    if value < 9.95:
        return b"%.1f" % value
    return b"%d" % int(min(value, LARGEST_ACCURACY) + 0.5)


def dilution(value: float) -> bytes:
    """A dilution of precision with two decimals, 99.99 at most."""
    return b"%.2f" % min(value, 99.99)


def xor_checksum(body: bytes) -> int:
    """XOR over all bytes.

    The body is folded as one long integer, by half its width, a quarter, …, until one byte is left. (A loop
    over bytes costs five times as much.)
    """
    folded = int.from_bytes(body, "little")
    shift = 512
    while 8 * len(body) > 2 * shift:
        shift *= 2
    while shift >= 8:
        folded ^= folded >> shift
        shift >>= 1
    return folded & 0xFF


def sentence(body: bytes) -> bytes:
    """The body between "$" and "*", with its checksum and line end."""
    return b"$" + body + _ENDINGS[xor_checksum(body)]
