"""Descriptions as TOML: read, checked against a pydantic model, and complained about in one clear message."""

from __future__ import annotations

import difflib
import tomllib
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

Model = TypeVar("Model", bound=BaseModel)


class DescriptionError(ValueError):
    """A description file is wrong. The message names file, key, value and a valid example."""


def read_toml(path: Path) -> dict[str, Any]:
    """Parse a TOML file; DescriptionError when it is missing or malformed."""
    try:
        with path.open("rb") as file:
            return tomllib.load(file)
    except FileNotFoundError:
        raise DescriptionError(f"{path}: no such file") from None
    except tomllib.TOMLDecodeError as error:
        raise DescriptionError(f"{path}: not valid TOML: {error}") from None
    except (OSError, UnicodeDecodeError) as error:
        raise DescriptionError(f"{path}: cannot be read: {error}") from None


def validated(model: type[Model], data: dict[str, Any], source: str) -> Model:
    """`data` as a `model`. Raises DescriptionError that tells the first thing that is wrong."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise DescriptionError(_message(model, data, source, error)) from None


def _message(model: type[BaseModel], data: dict[str, Any], source: str, error: ValidationError) -> str:
    first = error.errors()[0]
    location = first["loc"]
    key = ".".join(str(part) for part in location)
    owner, field = _owner(model, location)
    if first["type"] == "extra_forbidden":
        known = sorted(owner.model_fields) if owner else []
        near = difflib.get_close_matches(str(location[-1]), known, n=1)
        hint = f"did you mean {near[0]!r}?" if near else "known keys: " + ", ".join(known)
        return f"{source}: unknown key {key!r} (value {first['input']!r}); {hint}"
    example = _example(owner, field)
    if first["type"] == "missing":
        return f"{source}: key {key!r} is missing{example}"
    reason = first["msg"].removeprefix("Value error, ")
    return f"{source}: {key} = {first['input']!r}: {reason}{example}"


def _owner(model: type[BaseModel], location: tuple[Any, ...]) -> tuple[type[BaseModel] | None, str | None]:
    """The model class and field name that a location points into."""
    owner: type[BaseModel] | None = model
    found: tuple[type[BaseModel] | None, str | None] = (model, None)
    for part in location:
        if owner is not None and isinstance(part, str):
            found = (owner, part)
            if part in owner.model_fields:
                owner = _inner_model(owner.model_fields[part].annotation)
    return found


def _inner_model(annotation: Any) -> type[BaseModel] | None:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    for argument in getattr(annotation, "__args__", ()):
        inner = _inner_model(argument)
        if inner is not None:
            return inner
    return None


def _example(owner: type[BaseModel] | None, field: str | None) -> str:
    info = owner.model_fields.get(field) if owner is not None and field is not None else None
    if info is None or not info.examples:
        return ""
    return f"; for example: {field} = {info.examples[0]!r}"
