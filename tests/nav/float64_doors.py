"""The doors of navigation computing in float64."""

from types import ModuleType

from firmware.numerics.precision import load


def float64_doors() -> tuple[ModuleType, ModuleType, ModuleType]:
    """(imu, gnss, solution)."""
    names = ("firmware.nav.imu", "firmware.nav.gnss", "firmware.nav.solution")
    imu, gnss, solution = (load(name, "float64") for name in names)
    return imu, gnss, solution
