"""Where is the receiver, and what time is it there? Asked before the twin is put in the same place."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from firmware.drivers import gnss_epoch as epoch
from host.attach.receiver_port import ReceiverPort
from host.link.messages import Gnss, Satellites
from host.monitor.listener import Receiver
from host.record.errors import UserError

GPS_EPOCH = datetime(1980, 1, 6, tzinfo=UTC)
NEEDED = epoch.HAS_POSITION | epoch.HAS_TIME | epoch.HAS_DATE
POLL_S = 0.05
TELL_EVERY_S = 2.0
SENSELESS_S = 5.0
SENSELESS_BYTES = 600
"""For each message that was understood: the longest is shorter, and noise makes one in some 50 000."""
FULL_POLE_DEG = 89.0


@dataclass(frozen=True, slots=True)
class Fix:
    """The first valid fix."""

    latitude_deg: float
    longitude_deg: float
    height_m: float
    geoid_separation_m: float
    utc: datetime

    def text(self) -> str:
        """One line."""
        place = f"{self.latitude_deg:.6f}°, {self.longitude_deg:.6f}°, {self.height_m:.1f} m"
        return f"first fix: {place}, {self.utc:%Y-%m-%d %H:%M:%S} UTC"

    def overrides(self) -> tuple[str, ...]:
        """As changes of a scenario."""
        return (
            f"place.latitude_deg={self.latitude_deg!r}",
            f"place.longitude_deg={self.longitude_deg!r}",
            f"place.height_m={self.height_m!r}",
            f"place.geoid_separation_m={self.geoid_separation_m!r}",
            f'start.utc="{self.utc:%Y-%m-%dT%H:%M:%SZ}"',
        )


def wait_for_fix(port: ReceiverPort, limit_s: float, tell: Callable[[str], None]) -> Fix:
    """The first valid fix with time, date and height. Raises UserError when none comes in time."""
    receiver = Receiver(port.link.baud)
    begin = told = time.monotonic()
    received, tracked, latest = 0, 0, None
    while time.monotonic() - begin < limit_s:
        for came_ns, data in port.take() or [(time.monotonic_ns(), b"")]:
            received += len(data)
            for _, message in receiver.feed(data, came_ns / 1e9):
                if isinstance(message, Satellites):
                    tracked = sum(1 for one in message.satellites if one.cn0_dbhz)
                elif isinstance(message, Gnss):
                    latest = message
                    fix = _fix(message)
                    if fix is not None:
                        return fix
        senseless = received > SENSELESS_BYTES * (1 + receiver.heard)
        if senseless and time.monotonic() - begin > SENSELESS_S:
            raise UserError(
                f"--port {port.url}: {received} bytes at {port.link.baud} baud make no sense as NMEA or UBX;"
                " leave --baud out to have the rate found, or is it another kind of device?"
            )
        while port.notes:
            tell(port.notes.popleft())
        if time.monotonic() - told >= TELL_EVERY_S:
            told = time.monotonic()
            tell(f"waiting for a fix, {told - begin:.0f} s: {_state(received, receiver, tracked, latest)}")
        time.sleep(POLL_S)
    raise UserError(
        f"--port {port.url}: no fix within {limit_s:g} s ({_state(received, receiver, tracked, latest)});"
        " give it open sky, or more time with --wait"
    )


def _state(received: int, receiver: Receiver, tracked: int, latest: Gnss | None) -> str:
    if not received:
        return "nothing comes from the receiver"
    if not receiver.heard:
        return f"{received} bytes and nothing that a receiver says"
    if latest is None:
        return f"{receiver.heard} messages, no epoch yet"
    lacks = [
        name
        for flag, name in (
            (epoch.HAS_TIME, "time"),
            (epoch.HAS_DATE, "date"),
            (epoch.HAS_POSITION, "position"),
        )
        if not latest.flags & flag
    ]
    return f"{tracked} satellites tracked, {' and '.join(lacks) or 'height'} not known"


def _fix(message: Gnss) -> Fix | None:
    flags = message.flags
    if flags & NEEDED != NEEDED or not flags & (epoch.HAS_HEIGHT | epoch.HAS_HEIGHT_MSL):
        return None
    if abs(message.lat_nanodeg) > FULL_POLE_DEG * 1e9:
        raise UserError("the receiver stands within 1° of a pole, where navigation in north and east ends")
    ellipsoidal = message.height_mm if flags & epoch.HAS_HEIGHT else message.height_msl_mm
    known = flags & epoch.HAS_HEIGHT and flags & epoch.HAS_HEIGHT_MSL
    separation = (message.height_mm - message.height_msl_mm) / 1000 if known else 0.0
    since = timedelta(days=message.date_days, milliseconds=message.time_of_day_ms)
    return Fix(
        message.lat_nanodeg * 1e-9,
        message.lon_nanodeg * 1e-9,
        ellipsoidal / 1000,
        separation,
        (GPS_EPOCH + since).replace(microsecond=0),
    )
