// What all parts of the page use. Text of logs goes into the page as text alone: textContent, never markup.
"use strict";

const DATA = JSON.parse(document.getElementById("fleet-data").textContent);
const DASH = "—", MINUS = "\u2212", NARROW = "\u202f";

/** An element with attributes ("on…" are listeners, null ones are left out) and children: nodes, or texts. */
function el(tag, attributes, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

/** The same for drawings. */
function svg(tag, attributes, ...children) {
  return filled(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

function filled(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes || {})) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return node;
}

/** A name from a log: its direction of writing is its own, it breaks behind / _ and -, and a very long one is cut in its middle. */
function nameOf(text, longest = 90) {
  const letters = Array.from(text), head = Math.floor(longest / 3), long = letters.length > longest;
  const short = long ? letters.slice(0, head).join("") + "…" + letters.slice(head + 1 - longest).join("") : text;
  const parts = short.match(/[^/_-]*[/_-]+|[^/_-]+/g) || [short];
  return el("bdi", { title: long ? text : null }, parts.flatMap((part, k) => (k ? [el("wbr"), part] : [part])));
}

function chip(text, tone) {
  return el("span", { class: "badge " + tone }, text);
}

const known = (value) => typeof value === "number" && Number.isFinite(value);

function digits(value, decimals) {
  if (!known(value)) return DASH;
  const [whole, rest] = Math.abs(value).toFixed(Math.max(0, decimals)).split(".");
  const spaced = whole.length > 4 ? whole.replace(/\B(?=(\d{3})+$)/g, NARROW) : whole;
  const text = rest ? spaced + "." + rest : spaced;
  return value < 0 && Number(text.replaceAll(NARROW, "")) !== 0 ? MINUS + text : text;
}

/** A figure with as many digits as a spread of this size earns. */
function earned(value, spread) {
  if (!known(value)) return DASH;
  const size = known(spread) && spread > 0 ? spread : Math.abs(value) / 100 || 1;
  const decimals = Math.min(6, 1 - Math.floor(Math.log10(size)));
  return digits(decimals < 0 ? Math.round(value * 10 ** decimals) / 10 ** decimals : value, decimals);
}

const withUnit = (text, unit) => (text === DASH || !unit || unit === "–" ? text : text + NARROW + unit);

function chance(p) {
  if (!known(p)) return DASH;
  if (p < 1e-4) return "< 0.01" + NARROW + "%";
  return (p < 0.0995 ? (100 * p).toPrecision(2) : String(Math.round(100 * p))) + NARROW + "%";
}

function duration(seconds) {
  if (!known(seconds)) return DASH;
  if (seconds < 119.5) return Math.round(seconds) + NARROW + "s";
  const minutes = Math.round(seconds / 60);
  if (minutes < 60) return minutes + NARROW + "min";
  return Math.floor(minutes / 60) + NARROW + "h " + String(minutes % 60).padStart(2, "0") + NARROW + "min";
}

/** Date and time in UTC, whatever zone the reader is in. */
function dateTime(seconds) {
  return known(seconds) ? new Date(seconds * 1000).toISOString().slice(0, 16).replace("T", " ") : DASH;
}

const dateOnly = (seconds) => (known(seconds) ? dateTime(seconds).slice(0, 10) : DASH);

const plural = (n, one, many) => digits(n, 0) + " " + (n === 1 ? one : many || one + "s");

const STATUS = ["", "identified", "weak", "not identifiable"];
const TONES = ["quiet", "good", "warn", "quiet"];
const STATUS_OF = { identified: 1, weak: 2, not_identifiable: 3 };

/** What is said of a drive: with all drives of its vehicle joined where that is known, else what the drive says alone. */
function answerOf(parameter, drive) {
  for (const [source, from] of [["joined", parameter.joined], ["own", parameter.own]]) {
    if (!from) continue;
    const status = Number(from.status[drive]);
    if (status) return { source, status, value: from.value[drive], low: from.low[drive], high: from.high[drive] };
  }
  return { source: "", status: 0, value: null, low: null, high: null };
}

const PARAMETER = Object.fromEntries(DATA.parameters.map((parameter) => [parameter.name, parameter]));
const DRIVES = DATA.drives;

/** A drive's start; "local" where its log does not say of which time zone. */
const startText = (drive) => dateTime(DRIVES.start[drive]) + (DRIVES.local[drive] === "1" ? " local" : "");
const OF_VEHICLE = DATA.vehicles.map(() => []);
DRIVES.vehicle.forEach((vehicle, drive) => OF_VEHICLE[vehicle].push(drive));
