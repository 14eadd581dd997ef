"""How a served board does: for the control channel, for `--json`, and for the line in the terminal."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from hal.emulated.virtual_time import SECOND
from host.run.faults import name_of

if TYPE_CHECKING:
    from host.serve.service import Service


def status_of(service: Service) -> dict[str, Any]:
    """All of it; the keys are stable."""
    paced = service.paced
    session = service.session
    return {
        "time_s": session.now_ns / SECOND,
        "duration_s": session.world.duration_ns / SECOND,
        "pace": paced.pace,
        "paused": paced.paused,
        "running_s": paced.running_s,
        "achieved_pace": achieved_pace(service),
        "lateness": paced.lateness.figures(),
        "behind_s": paced.behind_s,
        "slips": paced.slips,
        "slipped_s": paced.slipped_s,
        "uarts": [_uart(line) for line in service.uarts],
        "can": [_can(can) for can in service.cans],
        "faults": [{"name": name_of(placed.fault), "fired": placed.fired()} for placed in session.faults],
    }


def achieved_pace(service: Service) -> float | None:
    """Virtual time for wall-clock time so far."""
    running_s = service.paced.running_s
    return service.session.now_ns / SECOND / running_s if running_s > 0.0 else None


def line_of(service: Service) -> str:
    """One line for people."""
    paced, lateness = service.paced, service.paced.lateness.figures()
    time_s = service.session.now_ns / SECOND
    if paced.paused:
        return f"{time_s:,.1f} s  paused"
    achieved = achieved_pace(service) or 0.0
    if not paced.pace:
        return f"{time_s:,.1f} s  as fast as it goes: {achieved:,.0f} × real time"
    told = f"{time_s:,.1f} s  pace {paced.pace:g}"
    if lateness["deadlines"]:
        told += (
            f"  {100 * (lateness['within_2_ms'] or 0.0):.2f} % within 2 ms;"
            f" median {lateness['p50_ms']:.2f}, 99 % {lateness['p99_ms']:.2f},"
            f" most {lateness['max_ms']:.1f} ms late"
        )
    if paced.slips:
        told += f"  FALLS BEHIND: {paced.slipped_s:,.1f} s lost, reaches pace {achieved:,.2f}"
    return told


def _uart(line: Any) -> dict[str, Any]:
    endpoint = line.endpoint
    return {
        "name": line.name,
        "where": endpoint.where,
        "leads_to": line.leads_to,
        "baud": line.baud,
        "bytes_sent": line.sent,
        "sha256_sent": line.digest,
        "bytes_written": line.written,
        "clients_now": endpoint.present,
        "backlog": endpoint.backlog,
        "waiting": endpoint.waiting,
        **asdict(endpoint.traffic),
    }


def _can(can: Any) -> dict[str, Any]:
    adapter = can.adapter
    return {
        "name": can.name,
        "where": adapter.where,
        "frames_sent": can.sent,
        "delivered": adapter.delivered,
        "lost": adapter.lost,
        "frames_written": can.written,
        "dropped": can.dropped + adapter.overrun,
        "foreign": adapter.foreign,
    }
