"""Reading a scenario file: TOML, inheritance, overrides, validation."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from boards.validation_messages import explain
from host.sim.scenario.errors import ScenarioError
from host.sim.scenario.overrides import apply_overrides
from host.sim.scenario.schema import Scenario


def load_scenario(path: str | Path, overrides: Iterable[str] = ()) -> Scenario:
    """The scenario in a TOML file, with overrides (`gnss.latency_s=0.1`) applied last.

    A file may say `inherit = "other"`: it then changes the scenario of that name in its folder. Tables are
    merged key by key, lists are replaced. Raises ScenarioError.
    """
    path = Path(path)
    data = apply_overrides(_read(path, ()), overrides)
    return scenario_from(data, path.stem, str(path), path)


def scenario_from(data: dict[str, Any], name: str, source: str, path: Path | None = None) -> Scenario:
    """A validated scenario from parsed data; `source` stands in front of messages. Raises ScenarioError."""
    for reserved in ("name", "path"):
        if reserved in data:
            raise ScenarioError(
                f"{source}: unknown key {reserved} = {data[reserved]!r}; a scenario is named by its file"
            )
    try:
        return Scenario.model_validate({**data, "name": name, "path": path})
    except ValidationError as error:
        raise ScenarioError(explain(error, Scenario, source)) from None


def source_text(path: Path) -> str:
    """The text of a scenario file, and below it of what it inherits: all that the scenario is made of."""
    text = path.read_text(encoding="utf-8")
    parent = _parse(path, ()).get("inherit")
    if parent is None:
        return text
    parent_path = path.parent / (parent if parent.endswith(".toml") else f"{parent}.toml")
    return f"{text}\n# --- inherited: {parent_path.name}\n{source_text(parent_path)}"


def _read(path: Path, heirs: tuple[Path, ...]) -> dict[str, Any]:
    """Parsed content of `path` on top of what it inherits."""
    data = _parse(path, heirs)
    parent = data.pop("inherit", None)
    if parent is None:
        return data
    if not isinstance(parent, str) or not parent:
        raise ScenarioError(
            f'{path}: inherit = {parent!r}: must name a scenario; for example inherit = "town-open"'
        )
    parent_path = path.parent / (parent if parent.endswith(".toml") else f"{parent}.toml")
    chain = (*heirs, path.resolve())
    if parent_path.resolve() in chain:
        names = " → ".join(p.stem for p in (*chain, parent_path.resolve()))
        raise ScenarioError(f"{path}: inherit goes in a circle: {names}")
    return merged(_read(parent_path, chain), data)


def _parse(path: Path, heirs: tuple[Path, ...]) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        known = sorted(p.stem for p in path.parent.glob("*.toml"))
        beside = f"; scenarios there: {', '.join(known)}" if known else ""
        origin = f" (inherited by {heirs[-1].name})" if heirs else ""
        raise ScenarioError(f"{path}: no such scenario file{origin}{beside}") from None
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(f"{path}: not valid TOML: {error}") from None
    except (OSError, UnicodeDecodeError) as error:
        raise ScenarioError(f"{path}: cannot be read: {error}") from None


def merged(base: dict[str, Any], top: dict[str, Any]) -> dict[str, Any]:
    """`base` with `top` laid over it: tables key by key, everything else replaced."""
    result = dict(base)
    for key, value in top.items():
        both = isinstance(value, dict) and isinstance(result.get(key), dict)
        result[key] = merged(result[key], value) if both else value
    return result
