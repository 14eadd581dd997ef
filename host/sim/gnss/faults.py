"""Faults of a scenario that happen in the receiver's own solution.

| kind | parameters |
| --- | --- |
| gnss-time-jump | offset_s: the reported time is off by this much |
| gnss-position-jump | north_m, east_m, down_m: the reported position is off by this much; at least one |
| gnss-spoofing | north_mps, east_mps, down_mps: reported velocity is off by this, and what it makes |
| gnss-jamming | loss_db: what the signals lose (`host.sim.gnss.jamming`) |
| gnss-baseline-lost | none: the second antenna is cut off |
| gnss-baseline-jump | heading_deg, pitch_deg, length_m, at least one: ambiguities are fixed wrongly |
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from host.sim.gnss.jamming import Jamming
from host.sim.gnss.schedule import NS, Glitch, Window
from host.sim.scenario.errors import ScenarioError
from host.sim.scenario.schema import Fault

TIME_JUMP = "gnss-time-jump"
POSITION_JUMP = "gnss-position-jump"
SPOOFING = "gnss-spoofing"
JAMMING = "gnss-jamming"
BASELINE_LOST = "gnss-baseline-lost"
BASELINE_JUMP = "gnss-baseline-jump"
BASELINE_FAULT_KINDS = (BASELINE_LOST, BASELINE_JUMP)
GNSS_FAULT_KINDS = (TIME_JUMP, POSITION_JUMP, SPOOFING, JAMMING, *BASELINE_FAULT_KINDS)
DEG = math.pi / 180.0
MOST = 1e9
"""Of any parameter: 30 years, or seven times round the equator and more."""
_PARAMETERS = {
    TIME_JUMP: ("offset_s",),
    POSITION_JUMP: ("north_m", "east_m", "down_m"),
    SPOOFING: ("north_mps", "east_mps", "down_mps"),
    JAMMING: ("loss_db",),
    BASELINE_LOST: (),
    BASELINE_JUMP: ("heading_deg", "pitch_deg", "length_m"),
}
_LARGEST = {SPOOFING: 1000.0, JAMMING: 100.0, BASELINE_JUMP: 180.0}
_EXAMPLES = {SPOOFING: "1.0", JAMMING: "12.0", BASELINE_JUMP: "2.0"}


def glitches_of(faults: Sequence[Fault], receiver: str, end_ns: int, seed: int) -> list[Glitch]:
    """The faults that strike the receiver called `receiver`; without a duration they last to `end_ns`.

    Raises ScenarioError when a parameter is unknown or not a number, or none says by how much.
    """
    return [
        _glitch(fault, end_ns, seed)
        for fault in faults
        if fault.kind in GNSS_FAULT_KINDS and fault.target == receiver
    ]


def refuse_baseline_faults(faults: Sequence[Fault], receiver: str) -> None:
    """Raises ScenarioError when one of them would strike the second antenna of a receiver that has none."""
    for fault in faults:
        if fault.kind in BASELINE_FAULT_KINDS and fault.target == receiver:
            raise ScenarioError(
                f"fault {fault.name!r}: target {receiver} has one antenna; {fault.kind} needs a receiver with"
                " two (second_antenna_m, --second-antenna)"
            )


def _glitch(fault: Fault, end_ns: int, seed: int) -> Glitch:
    name = fault.name or f"{fault.kind} {fault.target}"
    values = dict.fromkeys(_PARAMETERS[fault.kind], 0.0)
    for key, value in fault.parameters.items():
        if key not in values or isinstance(value, bool) or not isinstance(value, int | float):
            known = f"for example {_example(fault.kind)}" if values else "it takes none"
            raise ScenarioError(
                f"fault {name!r}: parameters.{key} = {value!r} is no number known here; {known}"
            )
        most = _LARGEST.get(fault.kind, MOST)
        if not -most <= value <= most:
            raise ScenarioError(
                f"fault {name!r}: parameters.{key} = {value!r} lies outside {-most:g} … {most:g};"
                f" for example {key} = {_EXAMPLES.get(fault.kind, '50.0')}"
            )
        values[key] = float(value)
    if values and not any(values.values()):
        known = _example(fault.kind)
        raise ScenarioError(
            f"fault {name!r}: parameters = {fault.parameters!r} must say by how much {fault.kind} is off;"
            f" for example parameters = {{ {known} }}"
        )
    start_ns = round(fault.at_s * NS)
    stop_ns = end_ns if fault.duration_s is None else start_ns + round(fault.duration_s * NS)
    window = Window(start_ns, max(start_ns, stop_ns))
    if fault.kind == TIME_JUMP:
        return Glitch(name, window, time_offset_ns=round(values["offset_s"] * NS))
    if fault.kind == JAMMING:
        if values["loss_db"] < 0.0:
            raise ScenarioError(
                f"fault {name!r}: parameters.loss_db = {values['loss_db']:g} must lie above 0; for example"
                f" {_example(fault.kind)}"
            )
        return Glitch(name, window, jamming=Jamming(values["loss_db"], seed, name))
    if fault.kind == BASELINE_LOST:
        return Glitch(name, window, baseline_lost=True)
    if fault.kind == BASELINE_JUMP:
        turn = (values["heading_deg"] * DEG, values["pitch_deg"] * DEG)
        return Glitch(name, window, baseline_turn=turn, baseline_stretch_m=values["length_m"])
    north, east, down = values.values()
    if fault.kind == SPOOFING:
        return Glitch(name, window, pull_ned_mps=(north, east, down))
    return Glitch(name, window, offset_ned_m=(north, east, down))


def _example(kind: str) -> str:
    return ", ".join(f"{key} = {_EXAMPLES.get(kind, '50.0')}" for key in _PARAMETERS[kind])
