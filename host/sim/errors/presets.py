"""Named sets of sensor errors, one TOML file each, with sources in its comments."""

from __future__ import annotations

import tomllib
from importlib.resources import files
from typing import Any

from host.sim.errors.schema import ImuErrors


def preset_names() -> list[str]:
    """The presets that come along."""
    folder = files("host.sim.errors") / "presets"
    return sorted(
        entry.name.removesuffix(".toml") for entry in folder.iterdir() if entry.name.endswith(".toml")
    )


def load_preset(name: str) -> ImuErrors:
    """The preset `name`. KeyError that lists the known names."""
    if name not in preset_names():
        raise KeyError(f"no sensor error preset {name!r}; known: {', '.join(preset_names())}")
    text = (files("host.sim.errors") / "presets" / f"{name}.toml").read_text(encoding="utf-8")
    return ImuErrors.model_validate(tomllib.loads(text))


def with_overrides(base: ImuErrors, overrides: ImuErrors) -> ImuErrors:
    """`base` with everything that `overrides` sets explicitly."""
    return ImuErrors.model_validate(_merged(base.model_dump(), overrides.model_dump(exclude_unset=True)))


def _merged(base: dict[str, Any], top: dict[str, Any]) -> dict[str, Any]:
    merged = dict(base)
    for key, value in top.items():
        nested = isinstance(value, dict) and isinstance(merged.get(key), dict)
        merged[key] = _merged(merged[key], value) if nested else value
    return merged
