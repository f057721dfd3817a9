// Puts the tables into the page and wires up its controls.
"use strict";

let drivesTable, vehiclesTable;
const FILTERS = ["text", "vehicle", "status", "only", "height-low", "height-high", "mass-low", "mass-high", "margin-low", "margin-high"];
const control = (name) => document.getElementById("f-" + name);

function filterDrives() {
  drivesTable.filter(filtersSay());
  const n = drivesTable.kept.length, all = drivesTable.order.length;
  document.getElementById("f-count").textContent = n === all ? plural(all, "drive") : `${digits(n, 0)} of ${plural(all, "drive")}`;
}

/** Set the filters named, clear the others, and go to the table. */
function setFilters(wanted) {
  for (const name of FILTERS) control(name).value = wanted[name] ?? "";
  filterDrives();
  document.getElementById("drives").scrollIntoView({ block: "start" });
}

function showVehicle(vehicle) {
  control("vehicles").value = "";
  vehiclesTable.filter(() => true);
  vehiclesTable.reveal(vehicle);
}

function filterVehicles() {
  const words = control("vehicles").value.toLowerCase().split(/\s+/).filter(Boolean);
  vehiclesTable.filter((v) => words.every((word) => DATA.vehicles[v].label.toLowerCase().includes(word)));
}

/** Call it when the reader pauses: typing stays quick in a table of 20 000 rows. */
function settled(action) {
  let timer = 0;
  return () => { clearTimeout(timer); timer = setTimeout(action, 120); };
}

function start() {
  const drives = document.getElementById("drives-table"), vehicles = document.getElementById("vehicles-table");
  if (!drives || !vehicles) return;
  drivesTable = new BigTable(drives, { caption: "All drives", columns: DRIVE_COLUMNS, rows: DRIVES.name.length, empty: "No drive passes these filters." });
  vehiclesTable = new BigTable(vehicles, { caption: "All vehicles", columns: VEHICLE_COLUMNS, rows: DATA.vehicles.length, detail: vehicleDetail, empty: "No such vehicle." });
  DATA.vehicles.forEach((vehicle, v) => control("vehicle").append(el("option", { value: v }, vehicle.label)));
  const later = settled(filterDrives);
  for (const name of FILTERS) control(name).addEventListener(control(name).tagName === "SELECT" ? "change" : "input", later);
  control("clear").addEventListener("click", () => setFilters({}));
  control("download").addEventListener("click", () => download(drivesTable.kept));
  control("vehicles").addEventListener("input", settled(filterVehicles));
  const shows = { failed: { status: "failed" }, changed: { only: "changed" }, near: { only: "near" } };
  for (const button of document.querySelectorAll("button[data-show]")) {
    button.hidden = false;
    button.addEventListener("click", () => setFilters(shows[button.dataset.show] || { text: button.dataset.show }));
  }
  filterDrives();
  vehiclesTable.sortBy(VEHICLE_COLUMNS.length - 1);
  if (DATA.vehicles.length === 1) vehiclesTable.reveal(0, false);
  window.addEventListener("beforeprint", () => drivesTable.show(true));
  window.addEventListener("afterprint", () => drivesTable.show());
  const redraw = settled(() => vehiclesTable.show());
  let wide = innerWidth;
  window.addEventListener("resize", () => { if (innerWidth !== wide) { wide = innerWidth; redraw(); } });
}

start();
