// SPDX-License-Identifier: GPL-2.0-or-later
// A table of any length: only the rows that are seen are elements. A telephone shows a row as a card.

import { element } from "./dom.js";

const MORE = 10; // rows above and below those that are seen
const PAD = 3; // characters beside a text

// `columns` are [{title, isRight, most}], `most` in characters; `rows` are lists of texts; `cell` returns what is in a
// cell. `name` is for those who do not see it.
export class LongTable {
  constructor({ columns, name, cell }) {
    this.columns = columns;
    this.cell = cell;
    this.rows = [];
    this.drawn = new Map(); // rows by place
    this.before = space();
    this.after = space();
    this.widths = columns.map(() => element("col"));
    this.body = element("tbody", {}, this.before, this.after);
    this.table = element("table", {}, element("colgroup", {}, ...this.widths), element("thead", {}, element("tr", { "aria-rowindex": 1 },
      ...columns.map(({ title, isRight }) => element("th", { scope: "col", className: isRight ? "number" : "" }, title)))), this.body);
    this.root = element("div", { className: "wide long", tabIndex: 0, role: "region", "aria-label": name, onscroll: () => this.draw() }, this.table);
    new ResizeObserver(() => this.resize()).observe(this.root);
  }

  show(rows) {
    this.rows = rows;
    this.table.setAttribute("aria-rowcount", rows.length + 1);
    this.columns.forEach(({ title, most = Infinity }, place) => {
      const longest = rows.reduce((length, row) => Math.max(length, row[place].length), title.length);
      this.widths[place].style.width = `${Math.min(longest, most) + PAD}ch`;
    });
    this.root.scrollTop = 0;
    this.renew();
  }

  renew() {
    for (const row of this.drawn.values()) row.remove();
    this.drawn.clear();
    this.height = 0;
    this.draw();
  }

  // The rows of a telephone are higher.
  resize() {
    const height = this.rowHeight();
    if (height && height !== this.height) this.renew();
    else this.draw();
  }

  rowHeight() {
    return this.root.offsetWidth ? parseFloat(getComputedStyle(this.root).getPropertyValue("--row")) : 0;
  }

  draw() {
    this.height ||= this.rowHeight();
    const { height, rows, root, drawn, before, after } = this;
    if (!height) return; // it is not seen
    const first = Math.floor(root.scrollTop / height);
    const begin = Math.max(first - MORE, 0), end = Math.min(first + Math.ceil(root.clientHeight / height) + MORE, rows.length);
    for (const [place, row] of drawn) {
      if (place >= begin && place < end) continue;
      row.remove();
      drawn.delete(place);
    }
    for (let place = end - 1, next = after; place >= begin; place--) {
      if (!drawn.has(place)) {
        drawn.set(place, this.make(place));
        next.before(drawn.get(place));
      }
      next = drawn.get(place);
    }
    before.style.height = `${begin * height}px`;
    after.style.height = `${Math.max(rows.length - end, 0) * height}px`;
  }

  make(place) {
    return element("tr", { "aria-rowindex": place + 2 }, ...this.rows[place].map((text, column) => {
      const { title, isRight, most } = this.columns[column];
      return element("td", { className: isRight ? "number" : "", "data-title": title, title: text.length > most ? text : "" }, this.cell(text, column, place));
    }));
  }
}

// A row that stands for those that are not seen.
const space = () => element("tr", { className: "space", "aria-hidden": "true" });
