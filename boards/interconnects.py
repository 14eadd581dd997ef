"""What joins two processors of one board, built from its description: for each kind a builder and a face."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from boards.description import DualPort, Interconnect
from hal.emulated.cpu import EmulatedCpu
from hal.emulated.dual_port import EmulatedDualPort

Ends = dict[str, Any]
"""What each processor sees of it, by the processor's name. An end counts `transactions` and `busy_ns`."""


class Kind(NamedTuple):
    """One kind of interconnect."""

    build: Callable[[str, Any, Mapping[str, EmulatedCpu]], Ends]
    """(name, description, processors) → ends."""
    face: str
    """Where a program finds its end: the field of `hal.board_io.BoardIo`."""


def _dual_port(name: str, facts: DualPort, cpus: Mapping[str, EmulatedCpu]) -> Ends:
    memory = EmulatedDualPort(name, facts.words, facts.word_bits // 8)
    return {processor: memory.side(cpus[processor], end.access_ns) for processor, end in facts.ends.items()}


KINDS: dict[str, Kind] = {"dual-port": Kind(_dual_port, "memories")}


def build(name: str, facts: Interconnect, cpus: Mapping[str, EmulatedCpu]) -> Ends:
    """The ends of one interconnect."""
    return KINDS[facts.kind].build(name, facts, cpus)


def ends_of(
    processor: str, described: Mapping[str, Interconnect], built: Mapping[str, Ends]
) -> dict[str, Ends]:
    """One processor's ends by name, as fields of its `BoardIo`."""
    found: dict[str, Ends] = {}
    for name, facts in described.items():
        if processor in built[name]:
            found.setdefault(KINDS[facts.kind].face, {})[name] = built[name][processor]
    return found
