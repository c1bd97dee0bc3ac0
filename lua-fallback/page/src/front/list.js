// SPDX-License-Identifier: GPL-2.0-or-later
// The packet list: only the rows that are seen are elements. Arrow keys, Page and Home, End move the selection.

import { element } from "./dom.js";
import { Heads } from "./heads.js";
import { faultsBy } from "./rule.js";

const ROW = 22; // pixels, as in page.css
const MORE = 8; // rows above and below those that are seen
const SAMPLE = 40; // rows that decide on widths, with the last number and time of the capture
const WIDEST = 26, WIDEST_TEXT = 54; // characters, but for the last column; of what the packet says

export class PacketList {
  // `onsort` gets what Capture.sortBy takes.
  constructor(capture, { columns, rules }, { onsort }) {
    this.capture = capture;
    this.columns = columns;
    this.isFault = faultsBy(rules);
    this.heads = new Heads(columns, { change: () => this.renew(this.root.scrollTop),
      sort: (column, order) => onsort(order === "none" ? null : { column: columns.indexOf(column), isDown: order === "descending" }) });
    this.body = element("div", { className: "rows", role: "rowgroup" });
    this.root = element("div", {
      className: "packet-list", role: "grid", tabIndex: 0, "aria-label": "Packets", "aria-readonly": "true",
      onscroll: () => this.draw(), onkeydown: (event) => this.press(event), onclick: (event) => this.click(event),
      onmouseover: (event) => showWhole(event.target),
    }, element("div", { role: "rowgroup", className: "head-group" }, this.heads.root), this.body);
    this.shown = columns; // those that are seen
    this.place = 0; // of the selected row
    this.drawn = new Map(); // rows by place
    this.numbers = new Map(); // of packets, by row
    for (const event of ["filtered", "grown", "sorted"]) capture.addEventListener(event, () => this.tellSorted());
    capture.addEventListener("filtered", () => this.renew(0));
    capture.addEventListener("grown", () => this.renew(this.root.scrollTop));
    capture.addEventListener("sorted", () => {
      this.renew(0);
      this.follow();
    });
    capture.addEventListener("rows", () => this.fill());
    capture.addEventListener("selected", () => this.follow());
    new ResizeObserver(() => this.draw()).observe(this.root);
  }

  tellSorted() {
    const { sort } = this.capture;
    this.heads.tell(sort ? { column: this.columns[sort.column], order: sort.isDown ? "descending" : "ascending" } : { column: null, order: "none" });
  }

  renew(scrollTop) {
    this.body.replaceChildren();
    this.drawn.clear();
    this.numbers.clear();
    const { matched } = this.capture;
    this.root.setAttribute("aria-rowcount", matched + 1);
    this.body.style.height = `${matched * ROW}px`;
    this.shown = this.heads.shown;
    const titles = this.shown.map(({ title }) => title).join();
    if (scrollTop === 0 || titles !== this.titles) this.fitted = "";
    this.titles = titles;
    this.root.scrollTop = scrollTop;
    this.draw();
  }

  get first() {
    return Math.floor(this.root.scrollTop / ROW);
  }

  get seen() {
    return Math.ceil((this.root.clientHeight - ROW) / ROW);
  }

  draw() {
    const { matched } = this.capture;
    const begin = Math.max(this.first - MORE, 0), end = Math.min(this.first + this.seen + MORE, matched);
    for (const [place, row] of this.drawn) {
      if (place >= begin && place < end) continue;
      row.remove();
      this.drawn.delete(place);
      this.numbers.delete(row);
    }
    for (let place = begin; place < end; place++) if (!this.drawn.has(place)) this.make(place);
    this.fill();
  }

  make(place) {
    const row = element("div", { className: "row waiting", role: "row", "aria-rowindex": place + 2, id: `row-${place}` },
      ...this.shown.map(({ isRight }) => element("span", { role: "gridcell", className: isRight ? "right" : "" })));
    row.style.top = `${place * ROW}px`;
    this.drawn.set(place, row);
    this.body.append(row);
  }

  fill() {
    for (const [place, row] of [...this.drawn].sort(([one], [other]) => other - one)) {
      if (!row.classList.contains("waiting")) continue;
      const packet = this.capture.row(place);
      if (packet) this.write(row, packet);
    }
    this.fit();
    this.mark();
  }

  write(row, { number, cells, paper, ink }) {
    row.classList.remove("waiting");
    this.numbers.set(row, number);
    row.classList.toggle("fault", this.isFault(paper));
    row.style.setProperty("--rule", paper || "transparent");
    row.style.setProperty("--rule-ink", ink);
    this.shown.forEach((column, place) => {
      const { digits } = column, text = cells[this.columns.indexOf(column)];
      row.children[place].textContent = digits === null || !text.includes(".") ? text : text.slice(0, text.indexOf(".") + 1 + digits);
    });
  }

  // How many characters a column needs at the end of the capture.
  atTheEnd({ format, digits }) {
    const { packets, seconds } = this.capture;
    if (format === "%m") return String(packets).length;
    return format === "%t" ? String(Math.floor(seconds)).length + 1 + (digits ?? 0) : 0;
  }

  // Gives the columns the widths of what is in the first rows; again when the capture has grown beyond them.
  fit() {
    const rows = [...this.drawn.values()].filter((row) => this.numbers.has(row)).slice(0, SAMPLE);
    const ends = this.shown.map((column) => this.atTheEnd(column));
    if (this.fitted === ends.join() || !rows.length) return;
    this.fitted = ends.join();
    const widths = this.shown.map(({ title, format }, place) =>
      Math.min(Math.max(title.length + 1, ends[place], ...rows.map((row) => row.children[place].textContent.length)), format === "%i" ? WIDEST_TEXT : WIDEST));
    const tracks = widths.map((width, place) => (place === widths.length - 1 ? "minmax(9rem, 1fr)" : `${width + 2}ch`));
    this.root.style.setProperty("--columns", tracks.join(" "));
  }

  mark() {
    const { number } = this.capture;
    for (const row of this.drawn.values()) {
      const isSelected = number > 0 && this.numbers.get(row) === number;
      row.classList.toggle("selected", isSelected);
      row.setAttribute("aria-selected", isSelected);
      if (isSelected) this.root.setAttribute("aria-activedescendant", row.id);
    }
  }

  async follow() {
    const { number } = this.capture;
    if (number) {
      this.place = await this.capture.placeOf(number);
      this.reveal(this.place);
    }
    this.mark();
  }

  reveal(place) {
    if (place < 0) return;
    const first = Math.ceil(this.root.scrollTop / ROW);
    if (place >= first && place < first + this.seen - 1) return;
    this.root.scrollTop = (place < first ? place : place - this.seen + 2) * ROW;
    this.draw();
  }

  async moveTo(place) {
    const { matched } = this.capture;
    if (!matched) return;
    this.place = Math.min(Math.max(place, 0), matched - 1);
    this.reveal(this.place);
    this.capture.isFollowing = this.place === matched - 1;
    const { place: asked } = this;
    const number = await this.capture.numberAt(asked);
    if (asked === this.place) await this.capture.select(number);
  }

  press(event) {
    const steps = { ArrowDown: 1, ArrowUp: -1, PageDown: this.seen - 1, PageUp: 1 - this.seen, Home: -Infinity, End: Infinity };
    if (!(event.key in steps) || event.altKey || event.ctrlKey) return;
    event.preventDefault();
    this.moveTo(this.place + steps[event.key]);
  }

  click(event) {
    const { number, place } = this.cellAt(event.target);
    if (!number) return;
    this.capture.isFollowing = false;
    this.place = place;
    this.capture.select(number);
  }

  // The packet's number and place, and the column, at an element; none outside the rows.
  cellAt(target) {
    const row = target.closest(".rows .row"), cell = target.closest(".rows .row > span");
    if (!this.numbers.has(row)) return {};
    return { number: this.numbers.get(row), place: row.ariaRowIndex - 2, column: cell ? this.shown[[...row.children].indexOf(cell)] : undefined };
  }

  get selected() {
    return this.body.querySelector(".selected");
  }

  // The text of the row at a place, or of one of its cells.
  text(place = this.place, ...columns) {
    const row = this.capture.rowOf(place);
    const wanted = columns.length ? columns : this.columns;
    return row ? wanted.map((column) => row.cells[this.columns.indexOf(column)]).join("\t") : "";
  }
}

// What is cut off is seen where the pointer is.
function showWhole(cell) {
  if (cell.matches(".rows .row > span")) cell.title = cell.scrollWidth > cell.clientWidth ? cell.textContent : "";
}
