// The table of all drives: its columns, its filters and its download.
"use strict";

const statusOf = (drive) => DRIVES.statuses[DRIVES.status[drive]];
const isDone = (drive) => statusOf(drive) === "done";
const FAILED = { error: "failed", crashed: "crashed", timeout: "took too long", memory: "out of memory", unknown: "not known" };

function driveName(drive) {
  const name = nameOf(DRIVES.name[drive]), link = DRIVES.href[drive];
  return link ? el("a", { href: link }, name) : name;
}

/** One standard deviation, as an interval of 95 % has it; as everywhere in reports. */
const spreadOf = (low, high) => (known(low) && known(high) ? (high - low) / 3.92 : null);

/** A parameter's value with its spread, and below it what the drive says alone where others helped. */
function figureCell(parameter, drive) {
  if (!parameter) return DASH;
  const answer = answerOf(parameter, drive);
  if (!known(answer.value)) return answer.status === 3 ? el("span", { class: "quiet", title: "this drive cannot tell it" }, "not identifiable") : DASH;
  const shown = (value, spread) => digits(value, parameter.digits) + (known(spread) ? " ±" + NARROW + digits(spread, parameter.digits) : "");
  const title = known(answer.low) ? `95 % between ${digits(answer.low, parameter.digits)} and ${digits(answer.high, parameter.digits)} ${parameter.unit}` : null;
  const lines = [el("span", { title }, shown(answer.value, spreadOf(answer.low, answer.high)))];
  const own = parameter.own;
  if (answer.source === "joined" && own) {
    const alone = known(own.value[drive]) ? shown(own.value[drive], spreadOf(own.low[drive], own.high[drive])) : STATUS[Number(own.status[drive])] || DASH;
    lines.push(el("span", { class: "sub" }, "alone " + alone));
  }
  return lines;
}

function chipsOf(drive) {
  if (!isDone(drive)) {
    const reason = DRIVES.reasons[DRIVES.reason[drive]];
    return [chip(FAILED[statusOf(drive)] || statusOf(drive), "bad"), reason ? el("span", { class: "sub why" }, reason) : null];
  }
  const height = PARAMETER.cg_height_m, status = height ? answerOf(height, drive).status : 0;
  return [
    chip("CG " + (status ? STATUS[status] : "not told"), TONES[status]),
    DRIVES.near[drive] === "1" ? chip("near rollover", "bad") : null,
    DRIVES.changed[drive] === "1" ? chip("load changed", "warn") : null,
    DRIVES.misfit[drive] === "1" ? chip("does not fit", "warn") : null,
    DRIVES.copy[drive] === "1" ? chip("copy", "quiet") : null,
    DRIVES.gone[drive] === "1" ? chip("log gone", "quiet") : null,
    DRIVES.lifts[drive] > 0 ? chip(plural(DRIVES.lifts[drive], "wheel lift"), "bad") : null,
  ].flatMap((badge) => (badge ? [badge, " "] : []));
}

const valueOf = (name) => (drive) => (PARAMETER[name] ? answerOf(PARAMETER[name], drive).value : null);
const rank = (drive) => (isDone(drive) ? 10 * (DRIVES.near[drive] !== "1") + 5 * (DRIVES.changed[drive] !== "1") + (answerOf(PARAMETER.cg_height_m || {}, drive).status || 4) : -1);

const DRIVE_COLUMNS = [
  { title: "Vehicle", value: (d) => DATA.vehicles[DRIVES.vehicle[d]].label, cell: (d) => el("button", { type: "button", class: "link", title: "open this vehicle", onclick: () => showVehicle(DRIVES.vehicle[d]) }, nameOf(DATA.vehicles[DRIVES.vehicle[d]].label, 40)) },
  { title: "Drive", value: (d) => DRIVES.name[d], cell: driveName },
  { title: "Start (UTC)", align: "tight", value: (d) => DRIVES.start[d], cell: (d) => startText(d) },
  { title: "Duration", align: "right", value: (d) => DRIVES.duration[d], cell: (d) => duration(DRIVES.duration[d]) },
  { title: "CG height, m", align: "right", value: valueOf("cg_height_m"), cell: (d) => figureCell(PARAMETER.cg_height_m, d) },
  { title: "Mass, kg", align: "right", value: valueOf("mass_kg"), cell: (d) => figureCell(PARAMETER.mass_kg, d) },
  { title: "SSF", align: "right", value: (d) => DRIVES.factor[d], cell: (d) => digits(DRIVES.factor[d], 2) },
  { title: "Least margin, g", align: "right", value: (d) => DRIVES.margin[d], cell: (d) => digits(DRIVES.margin[d], 2) },
  { title: "Status", value: rank, cell: chipsOf },
];

/** What the filters say now, as a test of a drive. */
function filtersSay() {
  const get = (id) => document.getElementById(id).value;
  const words = get("f-text").toLowerCase().split(/\s+/).filter(Boolean);
  const vehicle = get("f-vehicle"), status = get("f-status"), only = get("f-only");
  const range = (name) => ["low", "high"].map((end) => (get(`f-${name}-${end}`) === "" ? null : Number(get(`f-${name}-${end}`))));
  const ranges = [[range("height"), valueOf("cg_height_m")], [range("mass"), valueOf("mass_kg")], [range("margin"), (d) => DRIVES.margin[d]]];
  const text = (d) => `${DATA.vehicles[DRIVES.vehicle[d]].label} ${DRIVES.name[d]} ${startText(d)} ${DRIVES.reasons[DRIVES.reason[d]]} ${DRIVES.formats[DRIVES.format[d]]}`.toLowerCase();
  const told = (d) => (PARAMETER.cg_height_m && isDone(d) ? answerOf(PARAMETER.cg_height_m, d).status : 0);
  const tests = {
    done: isDone, failed: (d) => !isDone(d), identified: (d) => told(d) === 1, weak: (d) => told(d) === 2,
    untold: (d) => isDone(d) && (told(d) === 3 || told(d) === 0), "": () => true,
  };
  const marks = { changed: (d) => DRIVES.changed[d] === "1", near: (d) => DRIVES.near[d] === "1", notes: (d) => d in DRIVES.notes, "": () => true };
  return (d) => {
    if (vehicle !== "" && DRIVES.vehicle[d] !== Number(vehicle)) return false;
    if (!tests[status](d) || !marks[only](d)) return false;
    for (const [[low, high], value] of ranges) {
      if (low === null && high === null) continue;
      const figure = value(d);
      if (!known(figure) || (low !== null && figure < low) || (high !== null && figure > high)) return false;
    }
    if (!words.length) return true;
    const all = text(d);
    return words.every((word) => all.includes(word));
  };
}

/** One field of a CSV file; a text that a spreadsheet would take for a formula gets an apostrophe before it. */
function field(value) {
  if (value === null || value === undefined) return "";
  if (typeof value === "number") return String(value);
  const safe = /^[=+\-@\t\r]/.test(value) ? "'" + value : value;
  return /[",\n\r;]/.test(safe) ? '"' + safe.replaceAll('"', '""') + '"' : safe;
}

function csvOf(rows) {
  const heads = ["vehicle", "drive", "status", "reason", "start_utc", "duration_s"];
  for (const p of DATA.parameters) for (const source of ["joined", "own"]) if (p[source]) heads.push(...["", "_low", "_high", "_status"].map((end) => `${p.name}${end}${source === "own" ? "_alone" : ""}`));
  heads.push("static_stability_factor", "rollover_threshold_g", "least_margin_g", "exceedance_probability", "wheel_lifts", "near_rollover", "load_changed", "report");
  const line = (d) => {
    const start = DRIVES.start[d];
    const out = [DATA.vehicles[DRIVES.vehicle[d]].label, DRIVES.name[d], statusOf(d), DRIVES.reasons[DRIVES.reason[d]], known(start) ? new Date(start * 1000).toISOString().slice(0, DRIVES.local[d] === "1" ? -1 : undefined) : null, DRIVES.duration[d]];
    for (const p of DATA.parameters) for (const source of ["joined", "own"]) if (p[source]) out.push(p[source].value[d], p[source].low[d], p[source].high[d], STATUS[Number(p[source].status[d])]);
    out.push(DRIVES.factor[d], DRIVES.threshold[d], DRIVES.margin[d], DRIVES.exceedance[d], DRIVES.lifts[d], Number(DRIVES.near[d]), Number(DRIVES.changed[d]), DRIVES.href[d]);
    return out.map(field).join(",");
  };
  return [heads.join(","), ...rows.map(line)].join("\r\n") + "\r\n";
}

function download(rows) {
  const url = URL.createObjectURL(new Blob(["\ufeff", csvOf(rows)], { type: "text/csv;charset=utf-8" }));
  el("a", { href: url, download: "drives.csv" }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}
