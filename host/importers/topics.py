"""Topics of imported captures: their tables, and what their values can be.

`/imu/<name>` and `/gnss` begin with the columns that a run's captures have there; inertial samples are in
body axes, forward, right, down, as far as the recording tells.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from host.capture.inertial_samples import IMU
from host.importers.series import Series
from host.importers.units import Unit
from host.record.tables import Table


def table(*groups: tuple[int, str]) -> Table:
    """A table from (decimals, names)."""
    columns = ["t_s"]
    decimals = [9]
    for places, names in groups:
        columns += names.split()
        decimals += [places] * len(names.split())
    return Table(tuple(columns), tuple(decimals))


SAMPLES = table((7, " ".join(IMU.columns[1:])), (2, "temperature_degc"))
RATES, FORCES = IMU.columns[1:4], IMU.columns[4:7]
PLACE = ("latitude_deg", "longitude_deg", "height_m")
VELOCITY = ("v_north_mps", "v_east_mps", "v_down_mps")
ACCURACIES = ("h_acc_m", "v_acc_m", "s_acc_mps")
EPOCHS = table(
    (0, "fix"),
    (9, "latitude_deg longitude_deg"),
    (4, "height_m v_north_mps v_east_mps v_down_mps h_acc_m v_acc_m s_acc_mps"),
    (3, "geoid_separation_m"),
    (0, "satellites"),
    (2, "hdop"),
    (4, "latency_s"),
)
TRUTH = table(
    (10, "latitude_deg longitude_deg"),
    (4, "height_m"),
    (5, "v_north_mps v_east_mps v_down_mps"),
    (6, "yaw_deg pitch_deg roll_deg"),
)
ATTITUDE = table((5, "yaw_deg pitch_deg roll_deg"), (8, "q_w q_x q_y q_z"))
SATELLITES = table((0, "system number"), (1, "elevation_deg azimuth_deg cn0_dbhz"), (0, "used"))
OBSERVATIONS = table(
    (0, "system number signal"), (4, "pseudorange_m carrier_cycles doppler_hz"), (0, "cn0_dbhz")
)
FIELD = table((4, "field_x_ut field_y_ut field_z_ut"))

Place = Callable[[int], str]
Units = Mapping[str, Unit]
NO_UNITS: Units = {}

MOST_RATE_DPS = 20_000.0
MOST_FORCE = 5_000.0
LIMITS_OF_PLACES = {
    "latitude_deg": (-90.0, 90.0),
    "longitude_deg": (-180.0, 360.0),
    "height_m": (-12_000.0, 5e7),
    **dict.fromkeys(VELOCITY, (-12_000.0, 12_000.0)),
}


def samples(name: str, file: str, place: Place, units: Units = NO_UNITS) -> Series:
    """Inertial samples."""
    limits = dict.fromkeys(RATES, (-MOST_RATE_DPS, MOST_RATE_DPS)) | dict.fromkeys(
        FORCES, (-MOST_FORCE, MOST_FORCE)
    )
    axes = (*RATES, *FORCES)
    return Series(f"/imu/{name}", "navtwin.ImuSample", SAMPLES, file, place, axes, limits, axes, units)


def epochs(file: str, place: Place, units: Units = NO_UNITS) -> Series:
    """A receiver's solutions; nothing is needed, since there are epochs without a fix."""
    return Series("/gnss", "navtwin.GnssEpoch", EPOCHS, file, place, (), LIMITS_OF_PLACES, (), units)


def truth(file: str, place: Place, units: Units = NO_UNITS) -> Series:
    """A reference."""
    needed = (*PLACE, *VELOCITY)
    return Series("/truth", "navtwin.Truth", TRUTH, file, place, needed, LIMITS_OF_PLACES, (), units)


def attitude(file: str, place: Place, is_paced: bool = True) -> Series:
    """Angles or quaternions, body to north-east-down."""
    return Series("/attitude", "navtwin.Attitude", ATTITUDE, file, place, is_paced=is_paced)


def magnetic(name: str, file: str, place: Place, units: Units = NO_UNITS) -> Series:
    """A magnetometer."""
    axes = FIELD.columns[1:]
    return Series(f"/mag/{name}", "navtwin.MagneticField", FIELD, file, place, axes, {}, axes, units)


def satellites(file: str, place: Place) -> Series:
    """Satellites in view, a row each. `system`: 0 GPS, 1 SBAS, 2 Galileo, 3 BeiDou, 5 QZSS, 6 GLONASS."""
    return Series("/satellites", "navtwin.Satellite", SATELLITES, file, place, is_paced=False)


def observations(file: str, place: Place) -> Series:
    """Raw measurements, a row each."""
    return Series("/observations", "navtwin.Observation", OBSERVATIONS, file, place, is_paced=False)


def plain(topic: str, schema: str, columns: Table, file: str, place: Place, is_paced: bool = True) -> Series:
    """A table of another kind."""
    return Series(topic, schema, columns, file, place, is_paced=is_paced)
