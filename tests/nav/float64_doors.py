"""The doors of navigation computing in float64."""

from types import ModuleType

from firmware.numerics.precision import load


def float64_doors() -> tuple[ModuleType, ModuleType, ModuleType, ModuleType]:
    """(imu, gnss, solution, temperature)."""
    imu, gnss, solution, temperature = (
        load(f"firmware.nav.{name}", "float64") for name in ("imu", "gnss", "solution", "temperature")
    )
    return imu, gnss, solution, temperature
