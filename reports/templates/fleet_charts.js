// Drawings of a vehicle's parameters over time, made from the page's own figures.
"use strict";

const DAY = 86400;
const MARGIN = { left: 52, right: 12, top: 10, bottom: 24 };
const ASIDE = 3.5; // what the drive says alone stands so many pixels left of what all drives say
const MOST_POINTS = 1500; // beyond these, points are one path without words and links of their own

/** Steps of 1, 2 or 5 that put about so many ticks on a range. */
function niceTicks(low, high, wanted = 5) {
  const raw = (high - low) / wanted, size = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((k) => k * size).find((s) => s >= raw * 0.999);
  const out = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1) out.push(k * step);
  return { ticks: out, decimals: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
}

/** Ticks of time in UTC at whole days, months or years. */
function timeTicks(first, last, wanted) {
  const span = last - first;
  const days = [1, 2, 7, 14].find((n) => span / (n * DAY) <= wanted);
  const out = [];
  if (span < 2 * DAY) {
    const step = [1, 2, 3, 6, 12].map((h) => h * 3600).find((s) => span / s <= wanted) || 43200;
    for (let t = Math.ceil(first / step) * step; t <= last; t += step) out.push([t, dateTime(t).slice(5)]);
  } else if (days) {
    for (let t = Math.ceil(first / DAY) * DAY; t <= last; t += days * DAY) out.push([t, dateOnly(t)]);
  } else {
    const months = [1, 2, 3, 6, 12, 24, 60, 120].find((n) => span / (n * 30.4 * DAY) <= wanted) || 240;
    const start = new Date(first * 1000);
    for (let m = start.getUTCFullYear() * 12 + start.getUTCMonth(); ; m += 1) {
      const t = Date.UTC(Math.floor(m / 12), m % 12, 1) / 1000;
      if (t > last) break;
      if (t >= first && m % months === 0) out.push([t, months >= 12 ? String(Math.floor(m / 12)) : dateOnly(t).slice(0, 7)]);
    }
  }
  return out;
}

/** Where drives stand from left to right (0 to 1): by start; those without one behind the last; by order where few have one. */
function axisOf(drives, width) {
  const dated = drives.filter((d) => known(DRIVES.start[d]));
  const wanted = Math.max(2, Math.floor(width / 95));
  const [first, last] = dated.reduce(([a, b], d) => [Math.min(a, DRIVES.start[d]), Math.max(b, DRIVES.start[d])], [Infinity, -Infinity]);
  if (dated.length < 2 || dated.length < drives.length / 2 || last <= first) {
    const at = new Map(drives.map((d, k) => [d, (k + 0.5) / drives.length]));
    const { ticks } = niceTicks(1, Math.max(2, drives.length), wanted);
    const marks = ticks.filter((t) => Number.isInteger(t) && t >= 1 && t <= drives.length).map((t) => [(t - 0.5) / drives.length, String(t)]);
    return { title: "drive, in the table's order", at: (d) => at.get(d), marks, line: 1, place: () => null };
  }
  const undated = drives.filter((d) => !known(DRIVES.start[d]));
  const line = undated.length ? 0.9 : 1;
  const place = (t) => line * (0.015 + (0.97 * (Math.min(last, Math.max(first, t)) - first)) / (last - first));
  const behind = new Map(undated.map((d, k) => [d, line + ((1 - line) * (k + 0.5)) / undated.length]));
  const marks = timeTicks(first, last, wanted * line).map(([t, text]) => [place(t), text]);
  if (undated.length) marks.push([(1 + line) / 2, "no date"]);
  return { title: "start of the drive (UTC)", at: (d) => behind.get(d) ?? place(DRIVES.start[d]), marks, line, place };
}

/** The frame of a drawing: scales, grid, ticks. */
function frame(width, height, axis, low, high, label) {
  const { left, right, top, bottom } = MARGIN;
  const x = (share) => left + share * (width - left - right);
  const y = (value) => top + ((high - value) / (high - low)) * (height - top - bottom);
  const node = svg("svg", { viewBox: `0 0 ${width} ${height}`, width, height, role: "img", "aria-label": label, class: "chart" });
  const { ticks, decimals } = niceTicks(low, high, height < 150 ? 4 : 5);
  for (const tick of ticks) {
    node.append(svg("line", { x1: left, x2: width - right, y1: y(tick), y2: y(tick), class: "grid" }),
      svg("text", { x: left - 6, y: y(tick) + 3.5, class: "tick", "text-anchor": "end" }, digits(tick, decimals)));
  }
  for (const [share, text] of axis.marks) {
    const at = x(share);
    const anchor = at > width - 40 ? "end" : "middle";
    node.append(svg("line", { x1: at, x2: at, y1: height - bottom, y2: height - bottom + 4, class: "mark" }),
      svg("text", { x: anchor === "end" ? width - 2 : at, y: height - 7, class: "tick", "text-anchor": anchor }, text));
  }
  if (axis.line < 1) node.append(svg("line", { x1: x(axis.line), x2: x(axis.line), y1: top, y2: height - bottom, class: "undated" }));
  node.append(svg("line", { x1: left, x2: width - right, y1: height - bottom, y2: height - bottom, class: "mark" }));
  return { node, x, y, top, floor: height - bottom, clip: (value) => Math.min(high, Math.max(low, value)) };
}

/** A range that holds values, with a little air; wild ends beyond the usual are cut. */
function rangeOf(values, ends) {
  const sorted = [...ends].sort((a, b) => a - b);
  const cut = Math.floor(sorted.length * 0.03);
  let low = Infinity, high = -Infinity;
  for (const value of values) { low = Math.min(low, value); high = Math.max(high, value); }
  if (sorted.length) { low = Math.min(low, sorted[cut]); high = Math.max(high, sorted[sorted.length - 1 - cut]); }
  const air = 0.06 * (high - low) || Math.abs(high) * 0.02 || 1;
  return [low - air, high + air];
}

function whiskers(plot, rows, cls) {
  const path = rows.filter((r) => known(r.low) && known(r.high))
    .map((r) => `M${plot.x(r.x).toFixed(1)} ${plot.y(plot.clip(r.low)).toFixed(1)}V${plot.y(plot.clip(r.high)).toFixed(1)}`).join("");
  if (path) plot.node.append(svg("path", { d: path, class: cls }));
}

/** Points, each with words and the way to its drive's report; in very large numbers one path. */
function points(plot, rows, radius, cls) {
  if (rows.length > MOST_POINTS) {
    const path = rows.map((r) => `M${plot.x(r.x).toFixed(1)} ${plot.y(plot.clip(r.value)).toFixed(1)}h.01`).join("");
    plot.node.append(svg("path", { d: path, class: "cloud " + cls(rows[0]) }));
    return;
  }
  for (const row of rows) {
    const dot = svg("circle", { cx: plot.x(row.x).toFixed(1), cy: plot.y(plot.clip(row.value)).toFixed(1), r: radius, class: cls(row) }, svg("title", null, row.words));
    const link = DRIVES.href[row.drive];
    // reached by the table's links; a second stop of the keyboard at every dot would be in the way
    plot.node.append(link ? svg("a", { href: link, tabindex: "-1" }, dot) : dot);
  }
}

function changeLines(plot, axis, changes) {
  for (const change of changes) {
    if (!change.detected || change.drive === undefined || change.drive === null) continue;
    const at = plot.x(axis.at(change.drive));
    const words = "load changed: " + (change.text || `drive ${DRIVES.name[change.drive]}`);
    plot.node.append(svg("g", { class: "changed" }, svg("title", null, words),
      svg("line", { x1: at, x2: at, y1: plot.top, y2: plot.floor }), svg("path", { d: `M${at - 4} ${plot.top - 8}h8l-4 7z` })));
  }
}

function figure(title, drawing, words) {
  return el("figure", null, el("h4", null, title), drawing, words ? el("figcaption", null, words) : null);
}

/** One parameter over a vehicle's drives: alone in grey, with all drives joined in the colour of its status. */
function parameterChart(parameter, drives, changes, axis, width) {
  const rowsFrom = (source, from) => (from ? drives.filter((d) => known(from.value[d])) : []).map((d) => ({
    drive: d, x: axis.at(d), value: from.value[d], low: from.low[d], high: from.high[d], status: Number(from.status[d]),
    words: `${DRIVES.name[d]}\n${startText(d)}\n${source}: ${digits(from.value[d], parameter.digits)} ${parameter.unit}, 95 % ${digits(from.low[d], parameter.digits)}–${digits(from.high[d], parameter.digits)} (${STATUS[Number(from.status[d])]})`,
  }));
  const own = rowsFrom("this drive alone", parameter.own), joined = rowsFrom("with all drives", parameter.joined);
  const title = withUnit(parameter.title, "") + (parameter.unit && parameter.unit !== "–" ? ", " + parameter.unit : "");
  if (!own.length && !joined.length) return figure(title, el("p", { class: "missing" }, "No drive of this vehicle could tell it."));
  const lead = joined.length ? joined : own;
  const [low, high] = rangeOf([...own, ...joined].map((r) => r.value), lead.flatMap((r) => [r.low, r.high]).filter(known));
  const label = `${parameter.title} over ${plural(drives.length, "drive")}, from ${digits(Math.min(...lead.map((r) => r.value)), parameter.digits)} to ${digits(Math.max(...lead.map((r) => r.value)), parameter.digits)} ${parameter.unit}`;
  const plot = frame(width, 190, axis, low, high, label);
  if (joined.length) own.forEach((row) => { row.x -= ASIDE / (width - MARGIN.left - MARGIN.right); });
  changeLines(plot, axis, changes);
  if (joined.length) whiskers(plot, own, "alone");
  points(plot, own, joined.length ? 1.8 : 2.8, (row) => (joined.length ? "alone" : "s" + row.status));
  for (const status of [2, 1]) whiskers(plot, lead.filter((r) => r.status === status), "joined s" + status);
  points(plot, joined, 3, (row) => "s" + row.status);
  return figure(title, plot.node);
}

/** How near each drive came to rollover: its least margin, and below the line what is called near. */
function marginChart(drives, axis, width) {
  const rows = drives.filter((d) => known(DRIVES.margin[d])).map((d) => ({
    drive: d, x: axis.at(d), value: DRIVES.margin[d], near: DRIVES.near[d] === "1",
    words: `${DRIVES.name[d]}\n${startText(d)}\nleast margin ${digits(DRIVES.margin[d], 2)} g, threshold ${digits(DRIVES.threshold[d], 2)} g`,
  }));
  const title = "Rollover: least margin of each drive, g";
  if (!rows.length) return figure(title, el("p", { class: "missing" }, "No drive of this vehicle tells its margin."));
  const limits = drives.filter((d) => known(DRIVES.threshold[d])).map((d) => ({ x: axis.at(d), value: DRIVES.threshold[d] }));
  const [, high] = rangeOf([...rows, ...limits].map((r) => r.value), []);
  const low = Math.min(0, ...rows.map((r) => r.value - 0.03));
  const plot = frame(width, 190, axis, low, high, `Least margin of ${plural(rows.length, "drive")}, smallest ${digits(Math.min(...rows.map((r) => r.value)), 2)} g`);
  const top = plot.y(Math.min(high, DATA.near_g));
  plot.node.append(svg("rect", { x: plot.x(0), y: top, width: plot.x(1) - plot.x(0), height: plot.y(low) - top, class: "near" }));
  plot.node.append(svg("path", { d: limits.map((r) => `M${(plot.x(r.x) - 4).toFixed(1)} ${plot.y(r.value).toFixed(1)}h8`).join(""), class: "threshold" }));
  points(plot, rows, 3, (row) => (row.near ? "danger" : "margin"));
  return figure(title, plot.node, `Dashes: the threshold. Red ground: ${digits(DATA.near_g, 2)} g or less is called near.`);
}

/** A part that wears: the trend through the vehicle's value with its 95 % band, and single drives where they tell it. */
function trendChart(trend, shared, drives, axis, width) {
  const [from, to] = [axis.place(trend.from), axis.place(trend.to)];
  if (!known(trend.per_year) || !known(shared?.value) || !known(from) || !known(to) || trend.to <= trend.from) return null;
  const year = 365.25 * DAY, middle = (trend.from + trend.to) / 2, parameter = PARAMETER[trend.name];
  const line = Array.from({ length: 21 }, (_, k) => {
    const t = trend.from + ((trend.to - trend.from) * k) / 20, years = (t - middle) / year;
    const half = 1.96 * Math.hypot(shared.std || 0, (trend.std || 0) * years);
    const value = shared.value + trend.per_year * years;
    return { x: axis.place(t), value, low: value - half, high: value + half };
  });
  const own = parameter?.own, rows = (own ? drives.filter((d) => known(own.value[d])) : []).map((d) => ({
    drive: d, x: axis.at(d), value: own.value[d], low: own.low[d], high: own.high[d],
    words: `${DRIVES.name[d]}: ${earned(own.value[d], (own.high[d] - own.low[d]) / 4)} ${trend.unit}`,
  }));
  const [low, high] = rangeOf([...rows, ...line].map((r) => r.value), line.flatMap((r) => [r.low, r.high]));
  const plot = frame(width, 160, axis, low, high, `${trend.title}: ${trend.text}`);
  const way = (list, key) => list.map((r, k) => `${k ? "L" : "M"}${plot.x(r.x).toFixed(1)} ${plot.y(r[key]).toFixed(1)}`).join("");
  const band = way(line, "high") + way([...line].reverse(), "low").replace("M", "L") + "Z";
  whiskers(plot, rows, "alone");
  points(plot, rows, 1.8, () => "alone");
  plot.node.append(svg("path", { d: band, class: trend.detected ? "band drift" : "band" }), svg("path", { d: way(line, "value"), class: trend.detected ? "trend drift" : "trend" }));
  return figure(trend.title + (trend.unit && trend.unit !== "–" ? ", " + trend.unit : ""), plot.node, trend.text);
}
