"""Descriptions as TOML: read, checked against a pydantic model, and complained about in one clear message."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from boards.validation_messages import explain

Model = TypeVar("Model", bound=BaseModel)


class DescriptionError(ValueError):
    """A description file is wrong. The message names file, key, value and a valid example."""


def read_toml(path: Path) -> dict[str, Any]:
    """Parse a TOML file; DescriptionError when it is missing or malformed."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
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
        raise DescriptionError(explain(error, model, source)) from None
