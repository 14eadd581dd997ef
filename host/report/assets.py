"""Style and script of the report page."""

STYLE = """
:root { --ink: #22262b; --soft: #5c6672; --line: #dfe3e8; --blue: #1c6dd0; --good: #2b8a3e; --bad: #c0392b; }
* { box-sizing: border-box; }
body {
  margin: 0; background: #f4f6f8; color: var(--ink);
  font: 15px/1.5 system-ui, "Segoe UI", Roboto, sans-serif;
}
main { max-width: 1180px; margin: 0 auto; padding: 28px 24px 64px; }
header { display: flex; flex-wrap: wrap; align-items: baseline; gap: 4px 18px; margin-bottom: 18px; }
h1 { font-size: 26px; margin: 0; letter-spacing: -0.3px; }
h2 { font-size: 18px; margin: 0 0 2px; }
.run { color: var(--soft); }
.verdict { padding: 14px 20px; border-radius: 10px; color: #fff; font-size: 20px; font-weight: 600; }
.verdict.good { background: var(--good); } .verdict.bad { background: var(--bad); }
.verdict.none { background: var(--soft); }
.cards {
  display: grid; grid-template-columns: repeat(auto-fit, minmax(140px, 1fr));
  gap: 12px; margin: 14px 0;
}
.card, section { background: #fff; border: 1px solid var(--line); border-radius: 10px; }
.card { padding: 12px 14px; }
.card b { display: block; font-size: 20px; font-weight: 600; white-space: nowrap; }
.card span { color: var(--soft); font-size: 13px; }
section { padding: 18px 20px; margin: 14px 0; overflow-x: auto; }
p.note { margin: 0 0 8px; color: var(--soft); font-size: 13.5px; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin-top: 6px; }
th, td { padding: 5px 16px 5px 0; text-align: right; border-bottom: 1px solid #edf0f3; vertical-align: top; }
th { color: var(--soft); font-weight: 500; font-size: 13px; border-bottom-color: var(--line); }
th.word, td.word { text-align: left; }
td { white-space: nowrap; } td:last-child { padding-right: 0; }
tr:last-child td { border-bottom: 0; }
td.ok { color: var(--good); font-weight: 600; } td.no { color: var(--bad); font-weight: 600; }
details summary { cursor: pointer; color: var(--soft); }
pre {
  background: #f4f6f8; padding: 12px; border-radius: 8px; overflow-x: auto;
  font-size: 12.5px; line-height: 1.45;
}
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(480px, 1fr)); gap: 0 14px; }
.chart { width: 100%; }
.screens { display: flex; flex-wrap: wrap; gap: 12px; }
.screens figure { margin: 0; }
.screens img { image-rendering: pixelated; display: block; border-radius: 4px; }
figcaption { color: var(--soft); font-size: 13px; }
footer { color: var(--soft); font-size: 13px; margin-top: 24px; word-break: break-all; }
"""

SCRIPT = """
const data = JSON.parse(document.getElementById("data").textContent);
const figures = JSON.parse(document.getElementById("figures").textContent);
const columns = {};
function column(name) {
  if (!(name in columns)) {
    const bytes = Uint8Array.from(atob(data[name]), c => c.charCodeAt(0));
    columns[name] = new Float32Array(bytes.buffer);
  }
  return columns[name];
}
function values(reference) {
  if (!reference || !("$" in reference)) return reference;
  let found = column(reference.$);
  if (reference.times) found = found.map(value => value * reference.times);
  if (reference.plus) {
    const base = column(reference.plus);
    found = found.map((value, i) => value + base[i]);
  }
  return found;
}
const common = {
  margin: { l: 72, r: 16, t: 34, b: 46 }, paper_bgcolor: "#fff", plot_bgcolor: "#fff", hovermode: "closest",
  font: { family: 'system-ui, "Segoe UI", Roboto, sans-serif', size: 12.5, color: "#22262b" },
  legend: { orientation: "h", x: 0, y: 1, yanchor: "bottom", itemsizing: "constant", traceorder: "normal" },
};
const inTime = [];
for (const figure of figures) {
  const traces = figure.traces.map(trace => ({ ...trace, x: values(trace.x), y: values(trace.y) }));
  const buttons = [["zoom2d", "pan2d", "resetScale2d", "toImage"]];
  const pans = figure.layout.dragmode === "pan";
  const config = { displaylogo: false, responsive: true, scrollZoom: pans, modeBarButtons: buttons };
  Plotly.newPlot(figure.key, traces, { ...common, ...figure.layout }, config);
  if (figure.time) inTime.push(document.getElementById(figure.key));
}
let following = false;
for (const chart of inTime) {
  chart.on("plotly_relayout", change => {
    if (following) return;
    const update = {};
    for (const key of ["xaxis.range[0]", "xaxis.range[1]", "xaxis.autorange"])
      if (key in change) update[key] = change[key];
    if (Object.keys(update).length === 0) return;
    following = true;
    Promise.all(inTime.filter(other => other !== chart).map(other => Plotly.relayout(other, update)))
      .then(() => { following = false; });
  });
}
"""
