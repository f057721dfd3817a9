// The table of vehicles, and what opens under one: its parameters over time, what its drives share, trends, notes.
"use strict";

const FIRST = 5, MOST_NOTES = 50; // of a long list so many are seen at once, and at all
const RANGE_OF = new Map(); // "vehicle parameter" -> [lowest, middle, highest], worked out once

function rangeOfVehicle(vehicle, name, value) {
  const key = vehicle + " " + name;
  if (!RANGE_OF.has(key)) {
    const all = OF_VEHICLE[vehicle].map(value).filter(known).sort((a, b) => a - b);
    const half = all.length / 2;
    RANGE_OF.set(key, all.length ? [all[0], (all[Math.ceil(half) - 1] + all[Math.floor(half)]) / 2, all[all.length - 1]] : null);
  }
  return RANGE_OF.get(key);
}

function rangeColumn(title, name, decimals) {
  const range = (v) => rangeOfVehicle(v, name, valueOf(name));
  const cell = (v) => {
    const r = range(v);
    if (!r) return DASH;
    const [low, middle, high] = r.map((x) => digits(x, decimals));
    return [middle, low !== high ? el("span", { class: "sub" }, `${low}${r[0] < 0 || r[2] < 0 ? " to " : "–"}${high}`) : null];
  };
  return { title, align: "right", value: (v) => (range(v) ? range(v)[1] : null), cell };
}

const least = (v) => rangeOfVehicle(v, "margin", (d) => DRIVES.margin[d]);
const factors = (v) => rangeOfVehicle(v, "factor", (d) => DRIVES.factor[d]);
const detected = (rows) => rows.filter((row) => row.detected).length;
const lastStart = (v) => OF_VEHICLE[v].reduce((last, d) => (known(DRIVES.start[d]) && !(last > DRIVES.start[d]) ? DRIVES.start[d] : last), null);

function vehicleChips(v) {
  const { trends, outlier, changes } = DATA.vehicles[v];
  const near = OF_VEHICLE[v].filter((d) => DRIVES.near[d] === "1").length, changed = detected(changes), drifts = detected(trends);
  const told = DATA.parameters.some((p) => OF_VEHICLE[v].some((d) => known(answerOf(p, d).value)));
  return [
    near ? chip(near + " near rollover", "bad") : null,
    outlier?.outlying ? chip("outlier", "warn") : null,
    drifts ? chip(plural(drifts, "drift"), "warn") : null,
    changed ? chip(plural(changed, "load change"), "warn") : null,
    told ? null : chip("nothing told", "quiet"),
  ].flatMap((badge) => (badge ? [badge, " "] : []));
}

function attention(v) {
  const { trends, outlier, changes } = DATA.vehicles[v];
  const near = OF_VEHICLE[v].filter((d) => DRIVES.near[d] === "1").length;
  return -(1000 * near + 300 * Boolean(outlier?.outlying) + 100 * detected(trends) + 5 * detected(changes) + DATA.vehicles[v].failed);
}

const VEHICLE_COLUMNS = [
  { title: "Vehicle", value: (v) => DATA.vehicles[v].label, cell: (v) => nameOf(DATA.vehicles[v].label, 60) },
  { title: "Drives", align: "right", value: (v) => OF_VEHICLE[v].length, cell: (v) => [digits(OF_VEHICLE[v].length, 0), DATA.vehicles[v].failed ? el("span", { class: "sub bad-text" }, DATA.vehicles[v].failed + " failed") : null] },
  { title: "Last drive", align: "tight", value: lastStart, cell: (v) => dateOnly(lastStart(v)) },
  rangeColumn("CG height, m", "cg_height_m", PARAMETER.cg_height_m?.digits ?? 3),
  rangeColumn("Mass, kg", "mass_kg", PARAMETER.mass_kg?.digits ?? 0),
  { title: "Lowest SSF", align: "right", value: (v) => factors(v)?.[0], cell: (v) => digits(factors(v)?.[0], 2) },
  { title: "Least margin, g", align: "right", value: (v) => least(v)?.[0], cell: (v) => digits(least(v)?.[0], 2) },
  { title: "What asks for attention", value: attention, cell: vehicleChips },
];

/** The prior's 95 % range in grey and the interval from all drives in colour, on one scale. */
function bar(row, tone) {
  const ends = [];
  if (known(row.prior) && known(row.prior_std)) ends.push(row.prior - 1.96 * row.prior_std, row.prior + 1.96 * row.prior_std);
  const told = known(row.low) && known(row.high);
  const low = Math.min(...ends, ...(told ? [row.low] : [])), high = Math.max(...ends, ...(told ? [row.high] : []));
  if (!ends.length || !(high > low)) return null;
  const at = (value) => 3 + (94 * (value - low)) / (high - low);
  const node = svg("svg", { class: "bar", viewBox: "0 0 100 20", preserveAspectRatio: "none", "aria-hidden": "true" },
    svg("rect", { x: at(ends[0]), y: 6.5, width: at(ends[1]) - at(ends[0]), height: 7, fill: "#dce2e9" }));
  if (told) node.append(svg("rect", { x: at(row.low), y: 8.5, width: Math.max(0.8, at(row.high) - at(row.low)), height: 3, class: "fill-" + tone }));
  if (told && known(row.value)) node.append(svg("rect", { x: at(row.value) - 1, y: 5, width: 2, height: 10, class: "fill-" + tone }));
  return node;
}

function sharper(row) {
  if (!known(row.single_std) || !known(row.std) || row.std <= 0) return DASH;
  return (row.single_std / row.std).toFixed(1) + "×";
}

function sharedTable(vehicle) {
  const trendOf = Object.fromEntries(vehicle.trends.map((trend) => [trend.name, trend]));
  const line = (row) => {
    const status = STATUS_OF[row.status], trend = trendOf[row.name];
    const drift = trend && known(trend.per_year) ? `${earned(trend.per_year, trend.std)} ± ${earned(trend.std, trend.std)}` : DASH;
    return el("tr", null, el("th", { scope: "row" }, row.title),
      el("td", { class: "right" }, withUnit(earned(row.value, row.std) + (known(row.std) ? " ± " + earned(row.std, row.std) : ""), row.unit)),
      el("td", { class: "right" }, known(row.low) ? `${earned(row.low, row.std)} to ${earned(row.high, row.std)}` : DASH),
      el("td", null, bar(row, TONES[status])),
      el("td", null, chip(STATUS[status], TONES[status])),
      el("td", { class: "right quiet" }, known(row.prior) ? withUnit(`${earned(row.prior, row.prior_std)} ± ${earned(row.prior_std, row.prior_std)}`, row.unit) : DASH),
      el("td", { class: "right" }, sharper(row)),
      el("td", { class: "right" }, drift, trend?.detected ? [" ", chip("drift", "warn")] : null));
  };
  const heads = ["Parameter", "Value ± std", "95 % interval", "Prior, result", "Status", "Known before", "Sharper than one drive", "Change a year"];
  const right = new Set([1, 2, 5, 6, 7]);
  return el("div", { class: "scroll" }, el("table", { class: "dense" },
    el("caption", null, "What belongs to the vehicle whatever its load, from all its drives"),
    el("thead", null, el("tr", null, heads.map((text, k) => el("th", { scope: "col", class: right.has(k) ? "right" : null }, text)))),
    el("tbody", null, vehicle.shared.filter(isTold).map(line))));
}

const isTold = (row) => row.status === "identified" || row.status === "weak";

/** What the drives share; what they do not tell is only named. */
function sharedPart(vehicle) {
  const untold = vehicle.shared.filter((row) => !isTold(row)).map((row) => row.title);
  const why = [...new Set(vehicle.trends.filter((trend) => !known(trend.per_year) && trend.text).map((trend) => trend.text))];
  return [
    untold.length < vehicle.shared.length ? sharedTable(vehicle) : null,
    untold.length ? el("p", { class: "note" }, `Not identifiable from its drives: ${untold.join(", ")}.`) : null,
    why.length ? el("p", { class: "note" }, `Drifts: ${why.join("; ")}.`) : null,
  ].filter(Boolean);
}

function legend(hasJoined, axis) {
  const item = (cls, text) => el("li", null, svg("svg", { width: 16, height: 12, "aria-hidden": "true", class: "chart" },
    cls === "changed" ? svg("g", { class: cls }, svg("path", { d: "M4 3h8l-4 7z" })) : svg("g", null, svg("path", { d: "M8 1V11", class: cls === "alone" ? cls : "joined " + cls }), svg("circle", { cx: 8, cy: 6, r: cls === "alone" ? 1.8 : 3, class: cls }))), text);
  return el("ul", { class: "legend" }, hasJoined
    ? [item("s1", "all drives joined: identified"), item("s2", "weak"), item("alone", "the drive alone"), item("changed", "load changed")]
    : [item("s1", "the drive alone: identified"), item("s2", "weak"), item("changed", "load changed")], el("li", { class: "quiet" }, `Lines: 95 % intervals. Left to right: ${axis.title}. A point leads to its drive's report.`));
}

/** Notes of a vehicle's drives: what is said of all of them first, as it is about the vehicle. */
function notesOf(drives) {
  const often = new Map();
  for (const note of drives.flatMap((d) => DRIVES.notes[d] || [])) often.set(note, (often.get(note) || 0) + 1);
  return [...often].sort((a, b) => b[1] - a[1]).map(([note]) => DRIVES.words[note]);
}

/** All that is known of one vehicle. */
function vehicleDetail(v, width) {
  const vehicle = DATA.vehicles[v], all = OF_VEHICLE[v], drives = all.filter(isDone);
  const wide = Math.max(280, width - 24), two = wide > 760;
  const each = two ? Math.floor((wide - 24) / 2) : wide;
  const out = el("div", { class: "vehicle" });
  const show = el("button", { type: "button", class: "plain", onclick: () => setFilters({ vehicle: String(v) }) }, `Show its ${plural(all.length, "drive")} in the table`);
  out.append(el("h3", null, nameOf(vehicle.label, 120)), el("p", { class: "quiet" },
    `${plural(drives.length, "drive")} analysed` + (vehicle.failed ? `, ${vehicle.failed} failed` : "") + (vehicle.id && vehicle.id !== vehicle.label ? `. Identified as ${vehicle.id}. ` : ". "), show));
  if (vehicle.outlier?.outlying) out.append(el("p", { class: "alerts" }, `Outlier (rank ${vehicle.outlier.rank}, by chance ${chance(vehicle.outlier.probability)}): ${vehicle.outlier.text}`));
  if (drives.length) {
    const axis = axisOf(drives, each - MARGIN.left - MARGIN.right);
    const load = DATA.parameters.filter((p) => p.name.startsWith("cg_") || p.name === "mass_kg");
    const wears = vehicle.trends.map((t) => [t.name, trendChart(t, vehicle.shared.find((row) => row.name === t.name), drives, axis, each)]).filter(([, chart]) => chart);
    const drawn = new Set(wears.map(([name]) => name)), trends = wears.map(([, chart]) => chart);
    const others = DATA.parameters.filter((p) => !load.includes(p) && !drawn.has(p.name) && drives.some((d) => known(answerOf(p, d).value)));
    out.append(legend(load.some((p) => p.joined && drives.some((d) => known(p.joined.value[d]))), axis), el("div", { class: "charts" }, load.map((p) => parameterChart(p, drives, vehicle.changes, axis, each)), marginChart(drives, axis, each)));
    out.append(...sharedPart(vehicle));
    if (trends.length) out.append(el("h4", null, "Parts that wear"), el("div", { class: "charts" }, trends), el("p", { class: "note" }, "Line: the trend through the vehicle's value; band: its 95 % interval. Grey: single drives, loaded as they were. Orange: beyond chance."));
    if (others.length) out.append(el("details", null, el("summary", null, `${plural(others.length, "further parameter")} of the drives`), el("div", { class: "charts" }, others.map((p) => parameterChart(p, drives, [], axis, each)))));
  } else {
    out.append(el("p", { class: "missing" }, "None of its drives could be analysed: nothing is known of this vehicle."));
  }
  const told = vehicle.changes.filter((change) => change.detected && change.text);
  const items = (texts) => el("ul", { class: "list" }, texts.map((text) => el("li", null, text)));
  const list = (title, texts) => {
    if (!texts.length) return;
    out.append(el("h4", null, title), items(texts.slice(0, FIRST)));
    if (texts.length > FIRST) out.append(el("details", null, el("summary", null, `${texts.length - FIRST} more`), items(texts.slice(FIRST))));
  };
  list("Changes of load", told.map((change) => [known(change.drive) ? [known(DRIVES.start[change.drive]) ? startText(change.drive) + ", " : "", nameOf(DRIVES.name[change.drive], 60), ": "] : null, change.text]).map((parts) => el("span", null, parts.flat())));
  list("Notes", [...vehicle.notes, ...notesOf(all)].slice(0, MOST_NOTES));
  return out;
}
