"""Error curves: the figures of a campaign against the one key that it sweeps."""

from __future__ import annotations

from host.campaign.summary import Summary
from host.campaign.tables import SIDE_BY_SIDE, shown
from host.report.charts import FUSED, GNSS, TRUTH, Chart, Trace, dots, on_row, stacked

NOT_DRAWN = ("nees_mean", "overruns")
CURVES = {name: label for name, label in SIDE_BY_SIDE.items() if name not in NOT_DRAWN}


def error_curves(summary: Summary) -> list[Chart]:
    """For each key swept over numbers: the errors against it, where nothing else is swept."""
    swept = summary.setups[0].setup.swept if summary.setups else ()
    if len(swept) != 1 or len(summary.setups) < 2:
        return []
    key = swept[0][0]
    labels = shown(summary.setups, CURVES)
    names = [name for name in labels if all(name in one.figures for one in summary.setups)]
    if not names:
        return []
    texts = [one.setup.swept[0][1] for one in summary.setups]
    x = [_number(text) for text in texts]
    profiles = list(dict.fromkeys(one.setup.profile for one in summary.setups))
    traces: list[Trace] = []
    for place, name in enumerate(names):
        for colour, profile in zip((FUSED, GNSS, TRUTH, "#2b8a3e"), profiles, strict=False):
            chosen = [i for i, one in enumerate(summary.setups) if one.setup.profile == profile]
            spreads = [summary.setups[i].figures[name] for i in chosen]
            half = [0.0 if one.high is None else one.high - one.mean for one in spreads]
            points = dots([x[i] for i in chosen], [one.mean for one in spreads], profile, colour, size=7)
            points |= {"mode": "lines+markers", "error_y": {"type": "data", "array": half}}
            traces.append(on_row(points, place))
    numeric = [value for value in x if isinstance(value, float)]
    span = [min(numeric), max(numeric)] if len(numeric) == len(x) else [-0.5, len(x) - 0.5]
    margin = 0.04 * (span[1] - span[0])
    layout = stacked([labels[name] for name in names], [span[0] - margin, span[1] + margin])
    layout["xaxis"]["title"]["text"] = key
    text = "Mean over the seeds, with the 95 % interval of the mean."
    return [Chart("curves", f"Errors against {key}", text, traces, layout)]


def _number(text: str) -> float | str:
    try:
        return float(text.replace("_", ""))
    except ValueError:
        return text
