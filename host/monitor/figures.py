"""The view as numbers: one JSON object, for machines and logs. Field names end in the unit as in captures.

What was never told is null; so is what is no finite number.
"""

from __future__ import annotations

import json
import math
from typing import Any

from firmware.drivers import gnss_epoch as epoch
from firmware.link.frames import NO_DATE, NO_TIME_OF_DAY
from host.link.messages import Bias, Gnss, Innovation, Solution, Status
from host.monitor.motion_panels import attitude_sigmas
from host.monitor.state import BoardState
from host.monitor.view import MonitorView
from host.monitor.words import flag_names, mode_name
from host.record.tables import SLOW_STATES

NANO = 1e-9
COMPONENTS = ("north_m", "east_m", "down_m", "v_north_mps", "v_east_mps", "v_down_mps")


def figures_line(view: MonitorView) -> str:
    """The figures as one line."""
    return json.dumps(figures(view), allow_nan=False)


def figures(view: MonitorView) -> dict[str, Any]:
    """Everything that is known now."""
    state, link = view.state, view.link
    document = {
        "t_s": state.at_s,
        "board_s": state.board_us * 1e-6,
        "source": view.source,
        "link": {
            "frames": link.frames,
            "sentences": link.sentences,
            "bytes": link.bytes,
            "bad_crc": link.bad_crc,
            "lost": link.lost,
            "unknown": link.unknown,
            "garbage_bytes": link.garbage_bytes,
            "messages_per_s": link.messages_per_s,
            "bytes_per_s": link.bytes_per_s,
            "late_ms": link.late_ms,
            "worst_late_ms": link.worst_late_ms,
            "board_restarts": state.restarts,
        },
        "solution": _solution(state.solution),
        "gnss": _gnss(state),
        "satellites": None if state.satellites is None else [one._asdict() for one in state.satellites],
        "status": _status(state.status),
        "sensor": None if state.sensor is None else state.sensor._asdict(),
        "tasks": [one.figures._asdict() | {"load": one.load} for one in state.tasks.values()] or None,
        "innovation": _innovation(state.innovation),
        "bias": _bias(state.bias),
        "track": {"fused_points": len(state.track.fused.points), "gnss_points": len(state.track.gnss.points)},
        "events": [{"t_s": one.at_s, "text": one.text} for one in list(state.events)[-5:]],
    }
    cleaned: dict[str, Any] = _finite(document)
    return cleaned


def _solution(solution: Solution | None) -> dict[str, Any] | None:
    if solution is None:
        return None
    yaw, pitch, roll = attitude_sigmas(solution)
    deg = math.degrees
    return {
        "t_s": solution.time_us * 1e-6,
        "utc_time_of_day_ms": _known(solution.time_of_day_ms, NO_TIME_OF_DAY),
        "utc_date_days": _known(solution.date_days, NO_DATE),
        "mode": solution.mode,
        "mode_name": mode_name(solution.mode),
        "flags": solution.flags,
        "flag_names": [name for name, _ in flag_names(solution.flags)],
        "latitude_deg": solution.lat_nanodeg * NANO,
        "longitude_deg": solution.lon_nanodeg * NANO,
        "height_m": solution.height,
        "v_north_mps": solution.v_n,
        "v_east_mps": solution.v_e,
        "v_down_mps": solution.v_d,
        "yaw_deg": deg(solution.yaw),
        "pitch_deg": deg(solution.pitch),
        "roll_deg": deg(solution.roll),
        "rate_dps": [deg(solution.omega_x), deg(solution.omega_y), deg(solution.omega_z)],
        "sigma_north_m": solution.sigma_n,
        "sigma_east_m": solution.sigma_e,
        "sigma_down_m": solution.sigma_d,
        "sigma_v_north_mps": solution.sigma_v_n,
        "sigma_v_east_mps": solution.sigma_v_e,
        "sigma_v_down_mps": solution.sigma_v_d,
        "sigma_yaw_deg": deg(yaw),
        "sigma_pitch_deg": deg(pitch),
        "sigma_roll_deg": deg(roll),
    }


def _gnss(state: BoardState) -> dict[str, Any] | None:
    gnss = state.gnss
    if gnss is None:
        return None
    return {
        "t_s": gnss.time_us * 1e-6,
        "fix": state.fix,
        "utc_time_of_day_ms": _known(gnss.time_of_day_ms, NO_TIME_OF_DAY),
        "utc_date_days": _known(gnss.date_days, NO_DATE),
        "latitude_deg": _told(gnss, epoch.HAS_POSITION, gnss.lat_nanodeg * NANO),
        "longitude_deg": _told(gnss, epoch.HAS_POSITION, gnss.lon_nanodeg * NANO),
        "height_m": _told(gnss, epoch.HAS_HEIGHT, gnss.height_mm / 1000),
        "speed_mps": _told(gnss, epoch.HAS_SPEED, gnss.speed_mmps / 1000),
        "course_deg": _told(gnss, epoch.HAS_COURSE, gnss.course_e5deg * 1e-5),
        "satellites_used": gnss.satellites,
        "hdop": gnss.hdop_centi / 100 if gnss.hdop_centi else None,
        "sigma_horizontal_m": _told(gnss, epoch.HAS_ACCURACY, gnss.h_acc_mm / 1000),
        "sigma_vertical_m": _told(gnss, epoch.HAS_ACCURACY, gnss.v_acc_mm / 1000),
    }


def _told(gnss: Gnss, flag: int, value: float) -> float | None:
    return value if gnss.flags & flag else None


def _status(status: Status | None) -> dict[str, Any] | None:
    if status is None:
        return None
    fields = status._asdict()
    fields["t_s"] = fields.pop("time_us") * 1e-6
    return fields


def _innovation(innovation: Innovation | None) -> dict[str, Any] | None:
    if innovation is None:
        return None
    return {
        "t_s": innovation.time_us * 1e-6,
        "used": innovation.used,
        **dict(zip(COMPONENTS, innovation.values, strict=True)),
        **{f"sigma_{n}": value for n, value in zip(COMPONENTS, innovation.sigmas, strict=True)},
    }


def _bias(bias: Bias | None) -> dict[str, Any] | None:
    if bias is None:
        return None
    values = [_in_unit(n, v) for n, v in zip(SLOW_STATES, bias.values, strict=True)]
    sigmas = [_in_unit(n, v) for n, v in zip(SLOW_STATES, bias.sigmas, strict=True)]
    return {
        "t_s": bias.time_us * 1e-6,
        **dict(zip(SLOW_STATES, values, strict=True)),
        **{f"sigma_{n}": value for n, value in zip(SLOW_STATES, sigmas, strict=True)},
    }


def _in_unit(name: str, value: float) -> float:
    return math.degrees(value) if name.endswith(("_deg", "_dps")) else value


def _known(value: int, unknown: int) -> int | None:
    return None if value == unknown else value


def _finite(value: Any) -> Any:
    """The same without NaN and infinity, which JSON does not have."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {name: _finite(inner) for name, inner in value.items()}
    return [_finite(inner) for inner in value] if isinstance(value, list) else value
