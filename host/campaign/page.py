"""report.html of a campaign: verdict, figures with their confidence, envelopes, consistency."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from host.campaign.campaign import Finished
from host.campaign.charts import SETUPS_DRAWN, charts
from host.campaign.summary import Summary
from host.campaign.tables import interval, sections, verdict
from host.report.html import card, chart_block, chart_scripts, document, table
from host.report.numbers import number
from host.report.summary import Section

CARDS = (
    ("position_horizontal_rms_m", "m", "horizontal RMS"),
    ("velocity_rms_mps", "m/s", "velocity RMS"),
    ("yaw_rms_deg", "°", "yaw RMS"),
    ("nees_mean", "", "mean NEES (honest: 9)"),
)


def render(finished: Finished, summary: Summary, ok: bool, extra: Sequence[Section] = ()) -> str:
    """The whole page; `extra` tables stand right below the verdict."""
    manifest = finished.manifest
    drawn = charts(finished, summary)
    title = f"{manifest['board']} · {manifest['scenario']} · {manifest['kind']}"
    judged = extra or summary.failures or any(one.expectations for one in summary.setups)
    kind = "none" if ok and not judged else "good" if ok else "bad"
    left = len(summary.setups) - SETUPS_DRAWN
    note = f'<p class="note">Courses of {left} more set-ups are in the result file only.</p>'
    body = [
        heading(manifest, verdict(summary), kind),
        _cards(summary),
        *(table(section) for section in extra),
        *(table(section) for section in sections(summary)),
        note if left > 0 else "",
        *map(chart_block, drawn),
        provenance(manifest),
    ]
    return document(title, body, chart_scripts({}, drawn))


def heading(manifest: Mapping[str, Any], verdict_text: str, kind: str) -> str:
    """Name, extent and verdict."""
    extent = f"profiles {', '.join(manifest['profiles'])} · seeds {manifest['seeds']}"
    return (
        f"<header><h1>{escape(manifest['board'])} — {escape(manifest['scenario'])}</h1>"
        f'<span class="run">{escape(manifest["kind"])} · {escape(extent)}</span></header>\n'
        f'<div class="verdict {kind}">{escape(verdict_text)}</div>'
    )


def provenance(manifest: Mapping[str, Any]) -> str:
    """What ran: texts, changes, versions."""
    versions = " · ".join(f"{name} {text}" for name, text in manifest["versions"].items())
    texts = "".join(
        f"<details><summary>{escape(label)}</summary><pre>{escape(manifest[key])}</pre></details>"
        for label, key in (("Scenario file", "scenario_text"), ("Board file", "board_text"))
    )
    overrides = ", ".join(manifest["overrides"])
    changed = f"<p>Changed by --set: <code>{escape(overrides)}</code></p>" if overrides else ""
    return (
        f"<section><h2>What ran</h2>{changed}{texts}</section>"
        f"<footer>{escape(versions)}<br>sources {escape(manifest['sources'])}</footer>"
    )


def _cards(summary: Summary) -> str:
    if len(summary.setups) != 1:
        return ""
    found = summary.setups[0].figures
    cards = [
        card(number(found[name].mean, unit), f"{label}, 95 %: {interval(found[name])}")
        for name, unit, label in CARDS
        if name in found
    ]
    return '<div class="cards">' + "".join(cards) + "</div>"
