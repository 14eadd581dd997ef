"""How board and line are: link, flags, inertial sensor, tasks, innovations, events."""

from __future__ import annotations

import math

from rich.text import Text

from firmware.link import frames
from host.link.messages import Sensor
from host.monitor.bars import bar, sparkline
from host.monitor.link_health import LinkHealth
from host.monitor.state import BoardState, TaskLoad
from host.monitor.words import count, degrees, duration, flag_names, number

SILENT_S = 1.5
SPARK_SIGMAS = 3.0
COMPONENTS = ("N", "E", "D", "vN", "vE", "vD")
FULL_TASK_BAR = 0.25
NAME_WIDTH = 12
AGE_UNKNOWN = 0xFFFF
TROUBLE = ("stale", "jumps", "no_answer", "slipped", "gyro_saturated", "rates_lost", "field_implausible")
"""Counters of a SENSOR frame that are shown."""


def link_lines(state: BoardState, link: LinkHealth, width: int, height: int) -> list[Text]:
    """Rates, errors and lateness of the line, the flags in words, then what the board says of its inputs."""
    if link.bytes == 0 and link.frames == 0 and state.seen_s:
        return [Text("rows of a recording: no line to judge", "dim")]
    late = "-" if link.late_ms is None else f"{number(link.late_ms, 0)} ms"
    rates = [[(f"{number(link.messages_per_s, 1)} msg/s", "")]]
    rates += [[(f"{count(link.bytes_per_s)} B/s", "")]] if link.bytes else []
    errors = [_bad("bad CRC", link.bad_crc), _bad("garbage B", link.garbage_bytes)]
    if state.gnss is not None and link.frames == 0:
        return flowing([*rates, [(f"{count(link.sentences)} messages", "")], *errors], width)
    frames_told = [[(f"late {late}", "")], [(f"{count(link.frames)} frames", "")]]
    more = [_bad("lost", link.lost), _bad("unknown", link.unknown)]
    lines = flowing([*rates, *frames_told, *errors, *more], width)
    flags = flag_names(state.solution.flags) if state.solution is not None else []
    lines += flowing([[flag] for flag in flags or [("no flags", "green")]], width)
    status = state.status
    if status is not None:
        dated = "TIMEPULSE" if status.pulse_dated else "burst start"
        lines += flowing(
            [
                [(f"IMU {count(status.imu_reads)} reads", "")],
                _bad("missed", status.samples_missed),
                _bad("repeated", status.samples_repeated),
                _bad("restarts", max(status.imu_starts - 1, 0)),
                [(f"GNSS {count(status.gnss_epochs)} epochs", "")],
                _bad("bad", status.bad_checksums),
                _bad("garbage B", status.garbage_bytes),
                [(f"dated by {dated}", "")],
                _bad("dropped", status.frames_dropped),
                [(f"up {duration(state.board_us * 1e-6)}", "dim")],
                _bad("board restarts", state.restarts),
            ],
            width,
        )
    return lines


def _bad(name: str, value: int) -> list[tuple[str, str]]:
    return [(f"{name} ", "dim"), (count(value), "green" if value == 0 else "bold red")]


def flowing(groups: list[list[tuple[str, str]]], width: int) -> list[Text]:
    """Groups of (words, style) one behind the other, broken only between groups."""
    lines = [Text()]
    for group in groups:
        text = Text.assemble(*group)
        if lines[-1].cell_len and lines[-1].cell_len + 2 + text.cell_len > width:
            lines.append(Text())
        lines[-1] = Text("  ").join([lines[-1], text]) if lines[-1].cell_len else text
    return lines


def imu_lines(state: BoardState, width: int, height: int) -> list[Text]:
    """Rates of the body, estimated biases with σ, mounting and latency."""
    solution, bias = state.solution, state.bias
    lines = []
    if solution is not None:
        rates = (solution.omega_x, solution.omega_y, solution.omega_z)
        lines.append(_three("rate °/s", tuple(map(degrees, rates)), 2, "bold"))
    elif state.inertial is not None:
        lines.append(_three("rate °/s", tuple(map(degrees, state.inertial.rates)), 2, "bold"))
    if state.inertial is not None:
        lines.append(_three("force m/s²", state.inertial.forces, 2, "bold"))
    if state.sensor is not None:
        return lines + sensor_lines(state.sensor, width)
    if bias is None:
        return [*lines, Text("no biases yet", "dim")]
    values, sigmas = bias.values, bias.sigmas
    lines += [
        _three("gyro b °/s", tuple(map(degrees, values[0:3])), 3, ""),
        _three("acc b mg", tuple(v / 9.80665e-3 for v in values[3:6]), 2, ""),
        _three("  ± °/s", tuple(map(degrees, sigmas[0:3])), 3, "dim"),
        _three("  ± mg", tuple(v / 9.80665e-3 for v in sigmas[3:6]), 2, "dim"),
        Text(f"mount yaw {_with_sigma(degrees(values[6]), degrees(sigmas[6]), 2)}°", no_wrap=True),
        Text(f"mount pitch {_with_sigma(degrees(values[7]), degrees(sigmas[7]), 2)}°", no_wrap=True),
        Text(f"latency {_with_sigma(values[8] * 1e3, sigmas[8] * 1e3, 1)} ms", no_wrap=True),
    ]
    return lines


def sensor_lines(sensor: Sensor, width: int) -> list[Text]:
    """What a sensor measures beside motion, the age of its samples, and trouble with it so far."""
    known = sensor.age_most_us != AGE_UNKNOWN
    age = f"{sensor.age_least_us} … {sensor.age_most_us} µs" if known else "-"
    sound = sensor.diagnosis == 0
    told: list[list[tuple[str, str]]] = [
        [(f"supply {sensor.supply_mv / 1e3:.2f} V", "")],
        [(f"{sensor.temperature_centi_c / 100:.1f} °C", "")],
        [(f"{sensor.pressure_pa / 100:.1f} hPa", "")],
        [(f"field {sensor.field_nt / 1e3:.1f} µT", "")],
        [(f"sample age {age}", "")],
        [("flags ", "dim"), (f"0x{sensor.diagnosis:04X}", "green" if sound else "bold red")],
        [(f"{count(sensor.bursts)} bursts", "")],
    ]
    trouble = sensor._asdict()
    return flowing(told + [_bad(name.replace("_", " "), trouble[name]) for name in TROUBLE], width)


def _with_sigma(value: float, sigma: float, decimals: int) -> str:
    return f"{number(value, decimals)} ± {number(sigma, decimals)}"


def _three(name: str, values: tuple[float, ...], decimals: int, style: str) -> Text:
    return Text(f"{name:<10}" + "".join(number(v, decimals, 8) for v in values), style, no_wrap=True)


def task_lines(state: BoardState, width: int, height: int) -> list[Text]:
    """Load of each task, busiest first; response and missed deadlines."""
    if not state.tasks and not state.run_tasks:
        silent = frames.STATUS in state.seen_s
        why = ("not sent; profile key", "task_frames = true") if silent else ("no figures yet",)
        return [Text(line, "dim") for line in why]
    told = tuple(state.tasks.values()) or state.run_tasks
    tasks = sorted(told, key=lambda one: -(one.load or 0.0))
    known = [one.load for one in tasks if one.load is not None]
    missed = sum(one.figures.deadlines_missed for one in tasks)
    total = f"{sum(known):.1%}" if known else "-"
    head = Text.assemble(
        "tasks " if state.tasks else "whole run ",
        (total, "bold"),
        "  missed ",
        (str(missed), "green" if missed == 0 else "bold red"),
    )
    shown = [_task(one, width) for one in tasks[: max(height - 1, 0)]]
    return [head, *shown]


def _task(one: TaskLoad, width: int) -> Text:
    name = "".join(sign if sign.isprintable() else "·" for sign in one.figures.name)
    load = one.load or 0.0
    style = "bold red" if one.figures.deadlines_missed else "cyan"
    head = f"{name:<{NAME_WIDTH}.{NAME_WIDTH}} {min(load, 9.99):6.2%} "
    tail = f" {count(one.figures.worst_response_us):>5} µs"
    room = max(width - len(head) - len(tail), 0)
    return Text.assemble(head, (bar(load / FULL_TASK_BAR, room), style), (tail, "dim"), no_wrap=True)


def innovation_lines(state: BoardState, width: int, height: int) -> list[Text]:
    """Each component as a sparkline of innovation over σ, −3 … 3, and its latest value."""
    latest = state.innovation
    if latest is None:
        return [Text("no update yet", "dim")]
    lines = []
    for place, name in enumerate(COMPONENTS[: max(height, 1)]):
        ratios = [_ratio(one.values[place], one.sigmas[place]) for one in state.innovations]
        used = latest.used >> place & 1
        value, sigma = latest.values[place], latest.sigmas[place]
        tail = f"{number(value, 2, 7)} ±{number(sigma, 2)}"
        room = max(width - 4 - len(tail), 0)
        outside = used and abs(_ratio(value, sigma)) > SPARK_SIGMAS
        style = "bold red" if outside else "cyan" if used else "bright_black"
        lines.append(
            Text.assemble(
                f"{name:<3}",
                (sparkline(ratios, SPARK_SIGMAS, room), style),
                " ",
                (tail, "" if used else "dim"),
                no_wrap=True,
            )
        )
    return lines


def _ratio(value: float, sigma: float) -> float:
    return value / sigma if sigma > 0 and math.isfinite(value) else math.nan


def event_lines(state: BoardState, width: int, height: int) -> list[Text]:
    """The latest ones, newest last."""
    latest = list(state.events)[-max(height, 1) :]
    if not latest:
        return [Text("none yet", "dim")]
    return [Text.assemble((f"{duration(one.at_s)} ", "dim"), one.text, no_wrap=True) for one in latest]
