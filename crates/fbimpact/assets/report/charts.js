// Figures that zoom, drawn by uPlot in place of the drawings that the page holds.
"use strict";

report.charts = [];

// Moves the cursor of every chart to a time in seconds, or calls `follow` when one is moved.
report.follow = null;

report.dark = () => matchMedia("(prefers-color-scheme: dark)").matches;

const SUPERSCRIPTS = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };

// Divisions of a logarithmic axis, whose values are powers of ten.
function powers(values) {
  return values.map((v) => (Number.isInteger(v) ? "10" + [...String(v)].map((c) => SUPERSCRIPTS[c]).join("") : ""));
}

// As many digits as tell neighbouring divisions apart.
function divisions(_, values) {
  const step = values.length > 1 ? Math.abs(values[1] - values[0]) : 1;
  let digits = Math.max(0, Math.min(12, -Math.floor(Math.log10(step || 1) + 1e-9)));
  const is_rest = (d) => Math.abs(step * 10 ** d - Math.round(step * 10 ** d)) > 1e-6;
  while (digits < 12 && is_rest(digits)) digits++;
  return values.map((v) => v.toFixed(digits));
}

function axis({ label, log: is_log, ticks }, side) {
  const ink = report.dark() ? "#c8ccd0" : "#222222";
  const grid = { stroke: report.dark() ? "#3a3f44" : "#d8d8d8", width: 1 };
  const font = "12px system-ui, sans-serif";
  const common = { label, stroke: ink, grid, ticks: grid, font, labelFont: font, labelSize: 20, side };
  const values = is_log ? (_, all) => powers(all) : divisions;
  const made = Object.assign(common, { values, size: side === 3 ? 62 : 34 });
  if (ticks) {
    // What is counted has its own divisions.
    const within = (u) => ticks.filter(([at]) => at >= u.scales.x.min && at <= u.scales.x.max);
    Object.assign(made, { splits: (u) => within(u).map(([at]) => at), values: (u) => within(u).map(([, text]) => text) });
  }
  return made;
}

// Shades of phases below the curves, limits above them.
function marks(panel) {
  return {
    drawClear: (u) => {
      const { left, top, width, height } = u.bbox;
      u.ctx.save();
      for (const [from, to, kind] of panel.bands) {
        const a = Math.max(left, u.valToPos(from, "x", true));
        const b = Math.min(left + width, u.valToPos(to, "x", true));
        u.ctx.fillStyle = kind === "impact" ? "rgba(127,127,140,0.28)" : "rgba(127,127,140,0.07)";
        // What is narrower than a pixel shows as one.
        if (b + 1 > a) u.ctx.fillRect(a, top, Math.max(b - a, 1), height);
      }
      u.ctx.restore();
    },
    draw: (u) => {
      const { left, width } = u.bbox;
      u.ctx.save();
      u.ctx.strokeStyle = "#777778";
      u.ctx.setLineDash([4, 4]);
      for (const y of panel.limits) {
        const at = u.valToPos(y, "y", true);
        u.ctx.beginPath();
        u.ctx.moveTo(left, at);
        u.ctx.lineTo(left + width, at);
        u.ctx.stroke();
      }
      u.ctx.restore();
    },
  };
}

function pen(style) {
  const is_black = style.colour === "#000000";
  return { stroke: is_black && report.dark() ? "#ffffff" : style.colour, dash: style.dashes, width: 1.5 };
}

// Abscissas that all curves share, and the ordinates on them; what a curve lacks is undefined, a gap is null.
async function table(panel) {
  const tables = [];
  for (const curve of panel.curves) {
    const [x, y] = [await report.values(curve.x), await report.values(curve.y, null)];
    const ordinates = Array.from(y, (v) => (Number.isFinite(v) ? v : null));
    tables.push([Array.from(x), ordinates]);
  }
  return tables.length > 0 ? uPlot.join(rising(tables)) : [[], []];
}

// Curves over anything but rising abscissas cannot be joined: equal ones are moved apart by nothing that shows.
function rising(tables) {
  for (const [x] of tables) {
    for (let i = 1; i < x.length; i++) if (x[i] <= x[i - 1]) x[i] = x[i - 1] + Math.abs(x[i - 1]) * 1e-13 + 1e-300;
  }
  return tables;
}

// All abscissas unless a part of them is asked for.
function whole(range, x) {
  return (_, a, b) => (a == null || (a === x[0] && b === x[x.length - 1]) ? range : [a, b]);
}

// The range of the drawing as long as its extremes are seen, then that of the part with some room.
function ordinates(range, data) {
  let [low, high] = [Infinity, -Infinity];
  for (const y of data.slice(1).flat()) {
    if (y == null) continue;
    low = Math.min(low, y);
    high = Math.max(high, y);
  }
  return (_, a, b) => {
    if (a == null || (a <= low && b >= high)) return range;
    const room = 0.06 * (b - a) || 0.06 * Math.abs(a) || 1e-9;
    return [a - room, b + room];
  };
}

function width_of(place, columns) {
  const style = getComputedStyle(place);
  const room = place.clientWidth - parseFloat(style.paddingLeft) - parseFloat(style.paddingRight);
  const beside = room > 700 ? columns : 1;
  return Math.max(220, Math.floor(room / beside) - 8);
}

async function draw_panel(figure, panel, place) {
  const data = await table(panel);
  const names = figure.legend.filter((entry) => entry.sign === "curve");
  const series = [{ label: panel.x.label, value: (_, v) => (v == null ? "" : report.text(v, 7)) }];
  for (const curve of panel.curves) {
    const name = names.find((entry) => entry.style.colour === curve.style.colour);
    const show = curve.marks.length > 0 ? { show: true, size: 7 } : { show: false };
    const value = (_, v) => (v == null ? "" : panel.y.log ? report.text(10 ** v) : report.text(v));
    series.push(Object.assign(pen(curve.style), { label: name ? name.label : panel.title || panel.y.label, points: show, spanGaps: false, value }));
  }
  const box = document.createElement("div");
  box.className = "panel";
  place.append(box);
  if (panel.title) {
    const title = document.createElement("div");
    title.className = "panel-title";
    title.textContent = panel.title;
    box.append(title);
  }
  const is_tall = figure.panels.length === 1;
  const size = () => ({ width: width_of(place, figure.columns), height: is_tall ? 320 : 220 });
  const options = Object.assign(size(), {
    series,
    axes: [axis(panel.x, 2), axis(panel.y, 3)],
    scales: { x: { time: false, range: whole(panel.x.range, data[0]) }, y: { range: ordinates(panel.y.range, data) } },
    legend: { show: panel.curves.length <= 12 },
    cursor: { drag: { x: true, y: false }, sync: { key: panel.x.label } },
    hooks: {},
  });
  for (const [name, hook] of Object.entries(marks(panel))) options.hooks[name] = [hook];
  options.hooks.setCursor = [(u) => moved(u, panel)];
  const chart = new uPlot(options, data, box);
  once(chart);
  report.charts.push({ chart, size, panel });
}

// Several curves of one name have one line in the legend.
function once(chart) {
  const rows = chart.root.querySelectorAll(".u-legend .u-series");
  chart.series.forEach((series, i) => {
    if (rows[i] && chart.series.findIndex((other) => other.label === series.label) < i) rows[i].hidden = true;
  });
}

// The time under the cursor, for the bodies in motion.
function moved(u, panel) {
  const { idx } = u.cursor;
  if (idx == null || !report.follow || !/^time( [−+][^[]*)? \[/.test(panel.x.label) || !panel.x.second || !u.over.matches(":hover")) return;
  const [zero, second] = panel.x.second;
  report.follow((u.data[0][idx] - zero) / second);
}

report.draw_charts = async function (figures) {
  for (let i = 0; i < figures.length; i++) {
    const place = document.getElementById("figure-" + i);
    if (figures[i].panels.length === 0) continue;
    const charts = document.createElement("div");
    charts.className = "charts";
    place.append(charts);
    for (const panel of figures[i].panels) await draw_panel(figures[i], panel, charts);
  }
  let timer = 0;
  addEventListener("resize", () => {
    clearTimeout(timer);
    timer = setTimeout(() => report.charts.forEach(({ chart, size }) => chart.setSize(size())), 150);
  });
};
