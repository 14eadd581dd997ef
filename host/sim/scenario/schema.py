"""What a scenario file may say. Units stand in the names of the keys."""

from __future__ import annotations

import re
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field, ValidationError, field_validator, model_validator

from host.sim.errors.ambient_schema import BarometerErrors, CompassErrors, MagnetometerErrors
from host.sim.errors.presets import load_preset
from host.sim.errors.schema import ImuErrors
from host.sim.gnss.settings import GnssSettings
from host.sim.scenario.motion_matrix import segment_of_row
from host.sim.scenario.motion_schema import AnySegment
from host.sim.scenario.panel_schema import Panel
from host.sim.schema import NotNegative, Positive, Table

GPS_EPOCH = datetime(1980, 1, 6, tzinfo=UTC)
LATEST = datetime(2100, 1, 1, tzinfo=UTC)


class Place(Table):
    """Where the vehicle starts (WGS-84) and how far the geoid lies above the ellipsoid there."""

    latitude_deg: float = Field(ge=-89.0, le=89.0, examples=[30.5278])
    longitude_deg: float = Field(ge=-180.0, le=180.0, examples=[114.3557])
    height_m: float = Field(default=0.0, ge=-1000.0, le=100_000.0, examples=[35.0])
    geoid_separation_m: float = Field(default=0.0, ge=-120.0, le=100.0, examples=[-12.0])


def _as_text(value: Any) -> Any:
    """TOML has times of its own; keep them as text."""
    return value.isoformat() if isinstance(value, datetime) else value


class Start(Table):
    """UTC at the start of the run."""

    utc: Annotated[str, BeforeValidator(_as_text)] = Field(
        default="2024-05-14T08:00:00Z", examples=["2024-05-14T08:00:00Z"]
    )
    leap_seconds: int = Field(default=18, ge=0, le=60, examples=[18])

    @field_validator("utc")
    @classmethod
    def _is_utc(cls, value: str) -> str:
        try:
            moment = datetime.fromisoformat(value)
        except ValueError:
            raise ValueError("is not a time in ISO 8601") from None
        if moment.tzinfo is None or moment.utcoffset() != UTC.utcoffset(None):
            raise ValueError("must be UTC, marked by a Z at the end")
        if moment < GPS_EPOCH:
            raise ValueError("lies before 1980-01-06, where GPS time begins")
        if moment >= LATEST:
            raise ValueError("lies after 2099, too far ahead for receivers and leap seconds")
        return value

    @property
    def gps_time_ns(self) -> int:
        """GPS time of the start since 1980-01-06, ns."""
        elapsed = datetime.fromisoformat(self.utc) - GPS_EPOCH
        micros = (elapsed.days * 86400 + elapsed.seconds) * 1_000_000 + elapsed.microseconds
        return micros * 1000 + self.leap_seconds * 1_000_000_000


class Initial(Table):
    """Motion at the start of the run."""

    speed_mps: NotNegative = Field(default=0.0, le=1000.0, examples=[0.0])
    yaw_deg: float = Field(default=0.0, ge=-360.0, le=360.0, examples=[45.0])
    pitch_deg: float = Field(default=0.0, ge=-89.0, le=89.0, examples=[0.0])
    roll_deg: float = Field(default=0.0, ge=-89.0, le=89.0, examples=[0.0])


def _row(values: list[float]) -> str:
    return "[" + ", ".join(f"{value:g}" for value in values) + "]"


class Trajectory(Table):
    """How segments are joined. `matrix` = rows of source 002, table 3-1, followed to the letter."""

    blend_s: NotNegative = Field(default=0.5, le=10.0, examples=[0.5])
    matrix: list[Annotated[list[float], Field(min_length=2, max_length=4)]] | None = Field(
        default=None, min_length=1, examples=[[[1, 60, 0, 0], [3, 10, 12, 0], [7, 8, 0, 90]]]
    )

    @field_validator("matrix")
    @classmethod
    def _rows_are_segments(cls, value: list[list[float]] | None) -> list[list[float]] | None:
        for number, row in enumerate(value or [], start=1):
            try:
                segment_of_row(row)
            except ValidationError as error:
                first = error.errors()[0]
                detail = first["msg"].replace("Input should be", "must be")
                raise ValueError(f"row {number} {_row(row)}: {first['loc'][0]} {detail}") from None
            except ValueError as error:
                raise ValueError(f"row {number} {_row(row)}: {error}") from None
        return value


class Sway(Table):
    """Roll and pitch that the road gives a moving car: RMS at full size, band."""

    roll_deg: NotNegative = Field(default=0.0, le=20.0, examples=[0.4])
    pitch_deg: NotNegative = Field(default=0.0, le=20.0, examples=[0.3])
    low_hz: Positive = Field(default=0.1, le=5.0, examples=[0.1])
    high_hz: float = Field(default=1.5, gt=0.0, le=5.0, examples=[1.5])


class Vibration(Table):
    """Vibration of the vehicle: acceleration RMS per path axis over a band, and coning of the body."""

    x_mps2: NotNegative = Field(default=0.0, le=50.0, examples=[0.5])
    y_mps2: NotNegative = Field(default=0.0, le=50.0, examples=[0.5])
    z_mps2: NotNegative = Field(default=0.0, le=50.0, examples=[1.5])
    low_hz: float = Field(default=3.0, ge=0.5, le=20.0, examples=[3.0])
    high_hz: float = Field(default=15.0, ge=0.5, le=20.0, examples=[15.0])
    coning_deg: float = Field(default=0.0, ge=0.0, le=20.0, examples=[0.5])
    coning_hz: float = Field(default=5.0, gt=0.0, le=20.0, examples=[5.0])
    half_speed_mps: Positive = Field(default=2.0, le=1000.0, examples=[2.0])
    always: bool = False

    @model_validator(mode="after")
    def _band_is_a_band(self) -> Vibration:
        if self.high_hz <= self.low_hz:
            raise ValueError(f"high_hz = {self.high_hz:g} must lie above low_hz = {self.low_hz:g}")
        return self


class OutageWindow(Table):
    """No satellite signals for a while (a tunnel)."""

    start_s: NotNegative = Field(le=1e7, examples=[300.0])
    duration_s: Positive = Field(le=1e7, examples=[60.0])


Corner = Annotated[list[float], Field(min_length=2, max_length=2)]


class Tunnel(Table):
    """No satellite signals inside a polygon."""

    polygon: Annotated[list[Corner], Field(min_length=3, max_length=1000)] = Field(
        examples=[[[30.53, 114.35], [30.53, 114.36], [30.54, 114.36], [30.54, 114.35]]]
    )
    """Corners: latitude, longitude in °."""

    @field_validator("polygon")
    @classmethod
    def _corners_are_places(cls, value: list[Corner]) -> list[Corner]:
        for latitude, longitude in value:
            if abs(latitude) > 89.0 or abs(longitude) > 180.0:
                raise ValueError(
                    f"corner [{latitude:g}, {longitude:g}] must be a latitude of -89 … 89 and a longitude of"
                    " -180 … 180"
                )
        wide = [abs((corner[1] - value[0][1] + 180.0) % 360.0 - 180.0) for corner in value]
        if max(wide) > 90.0:
            raise ValueError(f"is {max(wide):g}° of longitude wide; at most 90")
        return value


class Fault(Table):
    """Something that breaks: `kind` and `target` are known to whoever injects it."""

    kind: str = Field(min_length=1, examples=["uart-cut"])
    target: str = Field(min_length=1, examples=["gnss"])
    at_s: NotNegative = Field(le=1e7, examples=[120.0])
    duration_s: Positive | None = Field(default=None, le=1e7, examples=[5.0])
    name: str | None = Field(default=None, min_length=1, examples=["receiver unplugged"])
    """No two faults have the same; left out it is kind and target, numbered from the second on."""
    parameters: dict[str, float | int | str | bool | list[float]] = Field(default_factory=dict)


def _with_names(faults: list[Fault]) -> list[Fault]:
    given = [fault.name for fault in faults if fault.name is not None]
    for name in given:
        if given.count(name) > 1:
            raise ValueError(f"two faults are called {name!r}; give each a name of its own")
    taken = set(given)
    named = []
    for fault in faults:
        own = fault.name or _free_name(f"{fault.kind} {fault.target}", taken)
        taken.add(own)
        named.append(fault.model_copy(update={"name": own}))
    return named


def _free_name(wanted: str, taken: set[str]) -> str:
    name, number = wanted, 1
    while name in taken:
        number += 1
        name = f"{wanted} {number}"
    return name


class RecordingSource(Table):
    """Which real recording drives the board, below the folder of --data or NAVTWIN_DATA."""

    file: str = Field(min_length=1, examples=["comma2k19/example_1.npz"])
    gyro: Literal["uncalibrated", "calibrated"] = "uncalibrated"
    geoid_separation_m: float = Field(default=0.0, ge=-120.0, le=100.0, examples=[-32.0])


@dataclass(frozen=True)
class Limit:
    """What a figure must satisfy: `relation` to `value`, or to the figure called `name`."""

    relation: Literal["<=", ">="]
    value: float | None
    name: str | None = None


_LIMIT = re.compile(r"^\s*(<=|>=)\s*(\S+)\s*$")


def limit_of(value: Any) -> Limit:
    """A limit as it is written under [expect]. Raises ValueError that tells what may stand there."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise ValueError('must be a number (an upper limit) or a text like "<= 2.5"')
    if isinstance(value, int | float):
        if not abs(value) < float("inf"):
            raise ValueError("must be a finite number")
        return Limit("<=", float(value))
    match = _LIMIT.match(value)
    if match is None:
        raise ValueError('must be a number or a text like "<= 2.5" or "<= gnss.position_horizontal_rms_m"')
    relation: Literal["<=", ">="] = "<=" if match[1] == "<=" else ">="
    try:
        return Limit(relation, float(match[2]))
    except ValueError:
        return Limit(relation, None, match[2])


def _flat_limits(value: Any) -> Any:
    """Nested tables as dotted names: [expect.metrics] yaw_rms_deg = 1.5 → metrics.yaw_rms_deg."""
    if not isinstance(value, dict):
        return value
    flat: dict[str, Limit] = {}
    for key, item in value.items():
        if isinstance(item, dict):
            flat |= {f"{key}.{inner}": limit for inner, limit in _flat_limits(item).items()}
        else:
            try:
                flat[key] = item if isinstance(item, Limit) else limit_of(item)
            except ValueError as error:
                raise ValueError(f"{key} = {item!r}: {error}") from None
    return flat


class Scenario(Table):
    """A whole scenario. `host.sim.scenario.load.load_scenario` makes one from a file."""

    name: str
    description: str = ""
    kind: Literal["simulated", "recording"] = "simulated"
    place: Place | None = Field(default=None, examples=[{"latitude_deg": 30.5278, "longitude_deg": 114.3557}])
    start: Start = Start()
    duration_s: Positive | None = Field(default=None, le=1e7, examples=[1200.0])
    initial: Initial = Initial()
    trajectory: Trajectory = Trajectory()
    segment: list[AnySegment] = Field(default=[], examples=[[{"kind": "rest", "duration_s": 60.0}]])
    sway: Sway = Sway()
    vibration: Vibration = Vibration()
    imu: ImuErrors = ImuErrors()
    gnss: GnssSettings = GnssSettings()
    magnetometer: MagnetometerErrors = MagnetometerErrors()
    compass: CompassErrors | None = Field(default=None, examples=[{"noise_deg": [0.5, 0.5, 1.0]}])
    """None: the noise of the part."""
    barometer: BarometerErrors = BarometerErrors()
    outage: list[OutageWindow] = Field(default=[], examples=[[{"start_s": 300.0, "duration_s": 60.0}]])
    tunnel: list[Tunnel] = Field(
        default=[], examples=[[{"polygon": [[30.53, 114.35], [30.53, 114.36], [30.54, 114.36]]}]]
    )
    fault: Annotated[list[Fault], AfterValidator(_with_names)] = Field(default_factory=list)
    panel: Panel = Panel()
    recording: RecordingSource | None = Field(default=None, examples=[{"file": "comma2k19/example_1.npz"}])
    board: dict[str, Any] = Field(default={}, examples=[{"chips": {"U3": {"lever_arm_m": [0.0, 0.0, 0.0]}}}])
    """What of the board's description is otherwise in this scenario: the same tables, merged key by key."""
    profile: dict[str, dict[str, str | int | float | bool]] = Field(
        default={}, examples=[{"full-rate": {"gnss_rate_hz": 5}}]
    )
    """For each profile of the board that the scenario changes: its settings."""
    expect: Annotated[dict[str, Limit], BeforeValidator(_flat_limits)] = Field(
        default={}, examples=[{"metrics.position_horizontal_rms_m": 2.5}]
    )
    path: Path | None = None
    """The file it came from."""

    @field_validator("imu")
    @classmethod
    def _preset_is_known(cls, value: ImuErrors) -> ImuErrors:
        if value.preset is not None:
            try:
                load_preset(value.preset)
            except KeyError as error:
                raise ValueError(error.args[0]) from None
        return value

    @model_validator(mode="after")
    def _kind_has_its_parts(self) -> Scenario:
        if self.kind == "recording":
            if self.recording is None:
                raise ValueError(
                    'kind = "recording" needs a table: [recording] file = "comma2k19/example_1.npz"'
                )
            return self
        if self.place is None:
            raise ValueError("needs a table: [place] latitude_deg = 30.5278, longitude_deg = 114.3557")
        if not self.segment and self.trajectory.matrix is None and self.duration_s is None:
            raise ValueError(
                'needs duration_s or motion, for example segment = [{ kind = "rest", duration_s = 600.0 }]'
            )
        if self.segment and self.trajectory.matrix is not None:
            raise ValueError("gives its motion twice, as segment and as trajectory.matrix; keep one")
        return self
