"""The mapping file of a CSV import: what columns mean, in which unit, axes and clock (docs/import.md)."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, model_validator

from boards.validation import read_toml, validated
from host.importers.units import QUANTITIES
from host.record.errors import UserError
from host.sim.schema import Table

Column = str | Annotated[int, Field(ge=1)]
"""A name in the header, or a number from 1 on."""
Three = Annotated[list[Column], Field(min_length=3, max_length=3)]

EXAMPLE = """\
[time]
column = "t"
unit = "s"                              # s, ms, us, ns, iso8601
base = "gps"                            # gps (since 1980), unix, week (with week = 2300), recording
[imu]
gyro = { columns = ["gx", "gy", "gz"], unit = "deg/s" }
accel = { columns = ["ax", "ay", "az"], unit = "g" }
axes = ["x", "-y", "-z"]                # forward, right, down, out of the sensor's axes"""


def _is_unit_of(quantity: str) -> AfterValidator:
    def check(value: str) -> str:
        if value not in QUANTITIES[quantity]:
            raise ValueError(f"is no unit of {quantity}; known: {', '.join(QUANTITIES[quantity])}")
        return value

    return AfterValidator(check)


class Time(Table):
    """The clock."""

    column: Column = Field(examples=["t"])
    unit: Literal["s", "ms", "us", "ns", "iso8601"] = "s"
    base: Literal["gps", "unix", "week", "recording"] = "recording"
    week: int | None = Field(default=None, ge=0, lt=10_000, examples=[2300])
    week_column: Column | None = Field(default=None, examples=["week"])

    @model_validator(mode="after")
    def _week_has_a_number(self) -> Time:
        if self.base == "week" and (self.week is None) == (self.week_column is None):
            raise ValueError('base = "week" needs week = 2300 or week_column = "week"')
        return self


class Gyro(Table):
    """Angular rates."""

    columns: Three = Field(examples=[["gx", "gy", "gz"]])
    unit: Annotated[str, _is_unit_of("gyro")] = Field(examples=["deg/s"])


class Accel(Table):
    """Specific forces."""

    columns: Three = Field(examples=[["ax", "ay", "az"]])
    unit: Annotated[str, _is_unit_of("accel")] = Field(examples=["g"])


class Mag(Table):
    """A magnetic field."""

    columns: Three = Field(examples=[["mx", "my", "mz"]])
    unit: Annotated[str, _is_unit_of("mag")] = Field(default="uT", examples=["uT"])


Axis = Literal["x", "y", "z", "-x", "-y", "-z"]


class Section(Table):
    """What all sections have."""

    file: str | None = Field(default=None, examples=["imu.csv"])
    time: Time | None = None


class Imu(Section):
    """An inertial sensor."""

    name: str = Field(default="imu", pattern=r"^[A-Za-z0-9_.-]+$", examples=["imu"])
    gyro: Gyro = Field(examples=[{"columns": ["gx", "gy", "gz"], "unit": "deg/s"}])
    accel: Accel = Field(examples=[{"columns": ["ax", "ay", "az"], "unit": "g"}])
    mag: Mag | None = None
    temperature: Column | None = Field(default=None, examples=["temp"])
    axes: list[Axis] = Field(default=["x", "y", "z"], examples=[["x", "-y", "-z"]])

    @model_validator(mode="after")
    def _axes_are_axes(self) -> Imu:
        if sorted(axis[-1] for axis in self.axes) != ["x", "y", "z"]:
            raise ValueError('axes must name x, y and z once each, e.g. ["x", "-y", "-z"]')
        return self


class Position(Table):
    """Latitude and longitude."""

    columns: Annotated[list[Column], Field(min_length=2, max_length=2)] = Field(examples=[["lat", "lon"]])
    unit: Annotated[str, _is_unit_of("position")] = Field(default="deg", examples=["deg"])


class Height(Table):
    """Height above the ellipsoid, or above mean sea level with the geoid's separation."""

    column: Column = Field(examples=["height"])
    unit: Annotated[str, _is_unit_of("height")] = Field(default="m", examples=["m"])
    above: Literal["ellipsoid", "sea"] = "ellipsoid"
    geoid_separation_m: float | None = Field(default=None, examples=[-32.0])

    @model_validator(mode="after")
    def _sea_has_its_separation(self) -> Height:
        if self.above == "sea" and self.geoid_separation_m is None:
            raise ValueError('above = "sea" needs geoid_separation_m, e.g. geoid_separation_m = -32.0')
        return self


class Velocity(Table):
    """Three components, or speed and course over ground."""

    columns: Three | None = Field(default=None, examples=[["vn", "ve", "vd"]])
    frame: Literal["ned", "enu"] = "ned"
    speed: Column | None = Field(default=None, examples=["speed"])
    course: Column | None = Field(default=None, examples=["course"])
    course_unit: Annotated[str, _is_unit_of("attitude")] = "deg"
    unit: Annotated[str, _is_unit_of("velocity")] = Field(default="m/s", examples=["m/s"])

    @model_validator(mode="after")
    def _is_told_once(self) -> Velocity:
        polar = self.speed is not None and self.course is not None
        if polar == (self.columns is not None) or (self.speed is None) != (self.course is None):
            raise ValueError('needs columns = ["vn", "ve", "vd"], or speed = "speed" and course = "course"')
        return self


class Attitude(Table):
    """Yaw, pitch, roll of forward, right, down to north, east, down (Z-Y-X)."""

    columns: Three = Field(examples=[["yaw", "pitch", "roll"]])
    unit: Annotated[str, _is_unit_of("attitude")] = Field(default="deg", examples=["deg"])


class Gnss(Section):
    """A receiver."""

    position: Position = Field(examples=[{"columns": ["lat", "lon"]}])
    height: Height = Field(examples=[{"column": "height"}])
    velocity: Velocity | None = None
    fix: Column | None = Field(default=None, examples=["fix"])
    h_acc: Column | None = None
    v_acc: Column | None = None
    s_acc: Column | None = None
    satellites: Column | None = None
    hdop: Column | None = None


class Truth(Section):
    """A reference."""

    position: Position = Field(examples=[{"columns": ["lat", "lon"]}])
    height: Height = Field(examples=[{"column": "height"}])
    velocity: Velocity = Field(examples=[{"columns": ["vn", "ve", "vd"]}])
    attitude: Attitude | None = None


class Mapping(Table):
    """The whole file."""

    delimiter: str | None = Field(default=None, min_length=1, max_length=1, examples=[","])
    header: bool = True
    skip_lines: int = Field(default=0, ge=0, examples=[2])
    time: Time | None = None
    imu: Imu | None = None
    gnss: Gnss | None = None
    truth: Truth | None = None

    @property
    def sections(self) -> dict[str, Section]:
        """Those that there are."""
        named = {"imu": self.imu, "gnss": self.gnss, "truth": self.truth}
        return {name: section for name, section in named.items() if section is not None}


def load_mapping(path: Path | None) -> Mapping:
    """Raises UserError (no mapping given) or DescriptionError."""
    if path is None:
        raise UserError(f"import csv: needs a mapping file, --map mapping.toml; for example\n{EXAMPLE}")
    mapping = validated(Mapping, read_toml(path), str(path))
    if not mapping.sections:
        raise UserError(f"{path}: has none of the tables [imu], [gnss], [truth]; for example\n{EXAMPLE}")
    for name, section in mapping.sections.items():
        if section.time is None and mapping.time is None:
            raise UserError(
                f"{path}: [{name}] has no time, and there is no table [time]; for example\n{EXAMPLE}"
            )
    return mapping
