"""The navigation loop of this program as data, for a processor that runs it on raw frames."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from firmware.apps.car_mems import steps
from firmware.apps.car_mems.navigation import Navigation, NavigationKernels, nav_config
from firmware.apps.car_mems.sample_clock import MISSED
from firmware.apps.car_mems.settings import Settings
from firmware.apps.car_mems.steps import CLOCK_AT
from firmware.apps.gnss_ins import gnss_time
from firmware.link.stand_alone import StandAlone
from firmware.nav import solution as record
from firmware.nav.gnss import gnss_step
from firmware.nav.temperature import temperature_step


def stand_alone(
    profile: Mapping[str, Any], installation: Mapping[str, Any], captures: Collection[str]
) -> StandAlone:
    """`captures`: pins wired to capture timers. Raises ValueError for a profile that no program could mean,
    and for one in double precision."""
    settings = Settings.of(profile)
    if settings.precision != "float32":
        raise ValueError(f"precision = {settings.precision!r}: the processor computes in float32")
    config = nav_config(settings, installation, "timepulse" in captures)
    navigation = Navigation(NavigationKernels(settings.precision), config)
    is_mean = settings.strapdown == "mean"
    return StandAlone(
        floats=navigation.f,
        integers=navigation.i,
        sample=steps.timer_sample if is_mean else steps.data_ready_step,
        epoch=gnss_step,
        temperature=temperature_step,
        solution=record.solution,
        each_sample=not is_mean,
        steps=settings.steps_per_output,
        clock=range(int(CLOCK_AT), int(CLOCK_AT) + MISSED),
        solution_floats=record.SOLUTION_FLOATS,
        solution_integers=record.SOLUTION_INTEGERS,
        nominal_latency_ns=gnss_time.NOMINAL_LATENCY_NS,
        longest_pulse_age_ns=gnss_time.LONGEST_PULSE_AGE_NS,
    )
