"""One clear message from a failed validation: file, key, value, what is wrong, a valid example."""

from __future__ import annotations

import json
from typing import Any, get_args, get_origin

from pydantic import BaseModel, ValidationError

from boards.hints import did_you_mean

_UNITS = {
    "s": "seconds",
    "m": "metres",
    "mps": "m/s",
    "mps2": "m/s²",
    "deg": "degrees",
    "dps": "°/s",
    "dph": "°/h",
    "hz": "hertz",
    "mg": "mg",
    "percent": "percent",
    "ppm": "ppm",
    "c": "°C",
    "k": "kelvin",
}


def explain(error: ValidationError, model: type[BaseModel], source: str) -> str:
    """One thing that is wrong, in one line: a misspelt key before what it leaves missing, else the first."""
    errors = error.errors()
    first = next((e for e in errors if e["type"] == "extra_forbidden"), errors[0])
    owner, path, key = _locate(model, first["loc"])
    value = _shown(first["input"])
    kind = first["type"]
    if kind == "extra_forbidden":
        return f"{source}: unknown key {path} = {value}; {_hint(owner, key)}"
    example = _example(owner, key)
    if kind == "missing":
        return f"{source}: {path} is missing{example}"
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        return f"{source}: {path}: {_unknown_kind(first)}"
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return f"{source}: {path} = {value}: must be a table{example}"
    return (
        f"{source}: {path} = {value}: {_reason(first, key)}{example}"
        if path
        else f"{source}: {_reason(first, key)}"
    )


def _reason(first: Any, key: str) -> str:
    if first["type"] in ("float_type", "int_type", "finite_number"):
        unit = _UNITS.get(key.rsplit("_", 1)[-1])
        return "must be a finite number" + (f" of {unit}" if unit and "_" in key else "")
    if first["type"] == "list_type":
        return "must be a list; a list of tables is headed [[…]] with double brackets"
    message = str(first["msg"]).removeprefix("Value error, ").replace("Input should be", "must be")
    return message[:1].lower() + message[1:]


def _hint(owner: type[BaseModel] | None, key: str) -> str:
    known = sorted(set(owner.model_fields) - {"path", "name"} if owner else ())
    stem, _, unit = key.rpartition("_")
    for candidate in known:
        other_stem, _, other_unit = candidate.rpartition("_")
        if other_unit in _UNITS and (stem == other_stem or key == other_stem) and unit != other_unit:
            return f"this quantity is given in {_UNITS[other_unit]}{_example(owner, candidate)}"
    return did_you_mean(key, known, "known keys")


def _unknown_kind(first: Any) -> str:
    expected = [tag.strip("' ") for tag in str(first["ctx"].get("expected_tags", "")).split(",")]
    given = first["ctx"].get("tag")
    if given is None:
        return 'key kind is missing; for example kind = "turn", duration_s = 8.0, angle_deg = 90.0'
    return f"kind = {_shown(given)} is not known; {did_you_mean(str(given), expected, 'known kinds')}"


def _locate(model: type[BaseModel], location: tuple[Any, ...]) -> tuple[type[BaseModel] | None, str, str]:
    """The model that owns the key, the key's dotted path as people write it, and the key."""
    owner: type[BaseModel] | None = model
    found: type[BaseModel] | None = model
    path, key = "", ""
    branches: list[type[BaseModel]] = []
    names_entry = False
    for part in location:
        if isinstance(part, int):
            path += f"[{part + 1}]"
            continue
        tagged = [branch for branch in branches if part in _tags(branch)]
        if tagged:
            owner, branches = tagged[0], []
            continue
        if part in _TYPE_NAMES or part.startswith(("constrained-", "function-", "list[")):
            continue
        path += f".{part}" if path else part
        if names_entry:
            names_entry = False
            continue
        found, key = owner, part
        annotation = owner.model_fields[part].annotation if owner and part in owner.model_fields else None
        branches = _inner_models(annotation)
        names_entry = get_origin(annotation) is dict
        owner = branches[0] if len(branches) == 1 else None
    return found, path, key


_TYPE_NAMES = {"float", "int", "str", "bool"}


def _tags(model: type[BaseModel]) -> tuple[Any, ...]:
    field = model.model_fields.get("kind")
    return get_args(field.annotation) if field is not None else ()


def _inner_models(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for argument in get_args(annotation) for model in _inner_models(argument)]


def _example(owner: type[BaseModel] | None, key: str) -> str:
    info = owner.model_fields.get(key) if owner is not None else None
    if info is None or not info.examples:
        return ""
    return f"; for example {key} = {_shown(info.examples[0])}"


def _shown(value: Any) -> str:
    """A value as TOML would write it, shortened."""
    if isinstance(value, dict):
        text = "{ " + ", ".join(f"{k} = {_shown(v)}" for k, v in value.items()) + " }"
    else:
        try:
            text = json.dumps(value, ensure_ascii=False)
        except TypeError:
            text = repr(value)
    return text if len(text) <= 120 else text[:117] + "..."
