// A table of many rows: sorted by any column, filtered, shown a page at a time, so that 20 000 rows do not freeze the page.
"use strict";

const COLLATE = new Intl.Collator("en", { numeric: true, sensitivity: "base" });
const PAGES = [25, 100, 500];
const MOST_PRINTED = 5000;

/**
 * columns: [{ title, align, value(row) -> number | text | null, cell(row) -> node or text, words }]; rows: how many.
 * detail(row) -> node: what opens under a row; name(row): what its button is called.
 */
class BigTable {
  constructor(host, { caption, columns, rows, detail = null, name = null, empty = "No row." }) {
    Object.assign(this, { columns, detail, name, empty, page: 0, size: PAGES[0], sorted: null, falling: false });
    this.order = Array.from({ length: rows }, (_, row) => row);
    this.kept = this.order;
    this.open = new Set();
    this.heads = columns.map((column, k) => this.head(column, k));
    this.body = el("tbody");
    const table = el("table", { class: "big" }, el("caption", { class: "out" }, caption),
      el("thead", null, el("tr", null, this.heads)), this.body);
    this.place = el("span", { class: "place" });
    this.pager = this.makePager(caption);
    host.append(this.makeSorter(), el("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": caption }, table), this.pager);
    this.show();
  }

  head(column, k) {
    if (!column.value) return el("th", { scope: "col" }, column.title);
    const button = el("button", { type: "button", onclick: () => this.sortBy(k) }, column.title, el("span", { class: "arrow", "aria-hidden": "true" }));
    return el("th", { scope: "col", class: column.align, "aria-sort": "none" }, button);
  }

  makePager(caption) {
    const step = (by) => () => { this.page += by; this.show(); };
    this.back = el("button", { type: "button", onclick: step(-1) }, "‹ Previous");
    this.next = el("button", { type: "button", onclick: step(1) }, "Next ›");
    const size = el("select", { onchange: () => { this.size = Number(size.value); this.page = 0; this.show(); } },
      PAGES.map((n) => el("option", { value: n }, String(n))));
    return el("nav", { class: "pager", "aria-label": "Pages: " + caption }, this.back, this.place, this.next,
      el("label", null, "Rows a page ", size));
  }

  /** What sorts where the heads are not shown: on a telephone each row is a card. */
  makeSorter() {
    const by = el("select", { onchange: () => this.sortBy(Number(by.value), false) },
      this.columns.map((column, k) => (column.value ? el("option", { value: k }, column.title) : null)));
    const turn = el("button", { type: "button", onclick: () => this.sortBy(Number(by.value)) }, "Other way round");
    return el("div", { class: "sorter" }, el("label", null, "Sort by ", by), turn);
  }

  /** Sort by a column; once more turns it round. What is missing stays last either way. */
  sortBy(k, falling = this.sorted === k ? !this.falling : false) {
    this.sorted = k;
    this.falling = falling;
    const keys = this.order.map((row) => this.columns[k].value(row));
    const sign = falling ? -1 : 1;
    const missing = (key) => key === null || key === undefined || key === "" || Number.isNaN(key);
    const compare = (a, b) => {
      const [x, y] = [keys[a], keys[b]];
      if (missing(x) || missing(y)) return missing(x) - missing(y) || a - b;
      const both = typeof x === "number" && typeof y === "number";
      return sign * (both ? x - y : COLLATE.compare(String(x), String(y))) || a - b;
    };
    this.kept = this.kept.slice().sort(compare);
    this.heads.forEach((head, at) => {
      if (head.hasAttribute("aria-sort")) head.setAttribute("aria-sort", at !== k ? "none" : falling ? "descending" : "ascending");
    });
    this.page = 0;
    this.show();
  }

  filter(keep) {
    this.kept = this.order.filter(keep);
    this.page = 0;
    if (this.sorted === null) this.show();
    else this.sortBy(this.sorted, this.falling);
  }

  show(all = false) {
    const last = Math.max(0, Math.ceil(this.kept.length / this.size) - 1);
    this.page = Math.min(Math.max(0, this.page), last);
    const first = all ? 0 : this.page * this.size;
    const rows = this.kept.slice(first, all ? MOST_PRINTED : first + this.size);
    const empty = el("tr", null, el("td", { colspan: this.columns.length, class: "quiet" }, this.empty));
    this.body.replaceChildren(...(rows.length ? rows.flatMap((row) => this.rowOf(row)) : [empty]));
    const end = first + rows.length;
    this.place.textContent = rows.length ? `${digits(first + 1, 0)}–${digits(end, 0)} of ${digits(this.kept.length, 0)}` : "0 of 0";
    this.back.disabled = this.page === 0;
    this.next.disabled = this.page === last;
    this.pager.hidden = this.order.length <= PAGES[0];
  }

  rowOf(row) {
    const cells = this.columns.map((column) =>
      el("td", { class: column.align, "data-label": column.title }, el("div", null, column.cell(row))));
    const line = el("tr", null, cells);
    if (!this.detail) return [line];
    const id = "detail-" + row;
    const button = el("button", { type: "button", class: "opener", "aria-expanded": String(this.open.has(row)), "aria-controls": id,
      onclick: () => { this.open.has(row) ? this.open.delete(row) : this.open.add(row); this.toggle(row, line, button, id); } },
      cells[0].firstChild.childNodes[0]);
    cells[0].firstChild.prepend(button);
    return this.open.has(row) ? [line, this.opened(row, id)] : [line];
  }

  toggle(row, line, button, id) {
    button.setAttribute("aria-expanded", String(this.open.has(row)));
    if (this.open.has(row)) line.after(this.opened(row, id));
    else if (line.nextSibling && line.nextSibling.id === id) line.nextSibling.remove();
  }

  opened(row, id) {
    const host = el("td", { colspan: this.columns.length });
    // drawn when it stands in the page, so that drawings know how wide they may be
    queueMicrotask(() => { if (!host.hasChildNodes()) host.append(this.detail(row, host.clientWidth)); });
    return el("tr", { id, class: "detail" }, host);
  }

  /** Show one row, wherever it is, open it, and go there if asked to. */
  reveal(row, go = true) {
    const at = this.kept.indexOf(row);
    if (at < 0) return;
    this.page = Math.floor(at / this.size);
    this.open.add(row);
    this.show();
    const line = document.getElementById("detail-" + row);
    if (go && line) line.previousSibling.scrollIntoView({ block: "start" });
  }
}
