// SPDX-License-Identifier: GPL-2.0-or-later
// The heads of the packet list's columns: a click sorts by one, a second one turns the order, a third one ends that. The
// menu of the heads says which columns are shown; that is remembered, where a page may remember something.

import { element } from "./dom.js";
import { openMenu, placeOf } from "./menu.js";
import { recall, remember } from "./storage.js";

const KEY = "sis.columns"; // the titles of those that are not shown
const SORTS = ["none", "ascending", "descending"], ARROWS = { ascending: "▲", descending: "▼", none: "" };
const HELP = "Click: sort. Right click, or the menu key: choose columns.";

const titlesOf = (kept) => (Array.isArray(kept) ? kept : []);

export class Heads {
  // `acts` are sort(column, order), and change() when other columns are shown. A column is that of the profile.
  constructor(columns, acts) {
    this.columns = columns;
    this.acts = acts;
    this.hidden = new Set(titlesOf(recall(KEY)));
    this.sorted = { column: null, order: "none" };
    this.root = element("div", { className: "row head", role: "row", "aria-rowindex": 1, onclick: (event) => this.turn(this.columnAt(event)),
      onkeydown: (event) => this.press(event), oncontextmenu: (event) => this.offer(event) });
    this.draw();
  }

  // The columns that are shown. The first is, whatever is remembered.
  get shown() {
    const shown = this.columns.filter(({ title }) => !this.hidden.has(title));
    return shown.length ? shown : this.columns.slice(0, 1);
  }

  draw() {
    const { column, order } = this.sorted;
    this.root.replaceChildren(...this.shown.map((one, place) => element("span", {
      role: "columnheader", className: one.isRight ? "right" : "", tabIndex: place ? -1 : 0, title: HELP,
      "aria-sort": one === column ? order : "none" }, one.title, element("i", { "aria-hidden": "true" }, one === column ? ARROWS[order] : ""))));
  }

  columnAt({ target }) {
    const head = target.closest(".head > span");
    return head ? this.shown[[...this.root.children].indexOf(head)] : null;
  }

  turn(column) {
    if (!column) return;
    const before = column === this.sorted.column ? this.sorted.order : "none";
    this.acts.sort(column, SORTS[(SORTS.indexOf(before) + 1) % SORTS.length]);
  }

  // Shows how the list is sorted.
  tell(sorted) {
    this.sorted = sorted;
    this.redraw();
  }

  redraw() {
    const place = [...this.root.children].indexOf(document.activeElement);
    this.draw();
    if (place >= 0) this.root.children[Math.min(place, this.root.children.length - 1)].focus();
  }

  press(event) {
    const { key, target } = event;
    if (event.altKey || event.ctrlKey) return;
    const step = { ArrowRight: target.nextElementSibling, ArrowLeft: target.previousElementSibling };
    if (key in step) step[key]?.focus();
    else if (key === "Enter" || key === " ") this.turn(this.columnAt(event));
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  offer(event) {
    event.preventDefault();
    openMenu(this.columns.map(({ title }) => ({ words: title, isOn: !this.hidden.has(title), act: () => this.tick(title) })), placeOf(event), "Columns");
  }

  tick(title) {
    if (!this.hidden.delete(title) && this.shown.length > 1) this.hidden.add(title);
    remember(KEY, [...this.hidden]);
    this.redraw();
    this.acts.change();
  }
}
