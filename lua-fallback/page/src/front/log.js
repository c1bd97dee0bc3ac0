// SPDX-License-Identifier: GPL-2.0-or-later
// The lines of a log beside its telegrams: capture.log.lines, IndexedLines. Chosen lines and packets light up both ways.

import { element } from "./dom.js";

const ROW = 22; // pixels, as in page.css
const MORE = 10;
const FIRST = 2; // packet 1 is the event
const TALLEST = 8_000_000; // pixels: no browser has an element of any height; of a longer log each pixel is more than one

export class LogLines {
  constructor(capture) {
    this.capture = capture;
    this.lines = null;
    this.lineOf = new WeakMap(); // of elements: the number of the line, of a packet
    this.packetOf = new WeakMap();
    this.body = element("div", { className: "log-body" });
    this.root = element("div", { className: "log", tabIndex: 0, role: "region", "aria-label": "Lines of the log",
      onscroll: () => this.draw(), onclick: (event) => this.click(event), onkeydown: (event) => this.press(event) }, this.body);
    capture.addEventListener("selected", () => this.follow());
    new ResizeObserver(() => this.draw()).observe(this.root);
  }

  begin() {
    this.lines = this.capture.log?.lines ?? null;
    this.body.style.height = `${Math.min(this.count * ROW, TALLEST)}px`;
    this.root.scrollTop = 0;
    this.draw();
  }

  get count() {
    return this.lines?.count ?? 0;
  }

  // How many lines a pixel of scrolling is.
  get step() {
    const seen = this.root.clientHeight;
    return this.count * ROW <= TALLEST ? 1 / ROW : (this.count - seen / ROW) / (TALLEST - seen);
  }

  draw() {
    const { scrollTop, clientHeight } = this.root;
    const top = scrollTop * this.step; // a line and a part of it
    const first = Math.max(Math.floor(top) - MORE, 0), end = Math.min(Math.ceil(top + clientHeight / ROW) + MORE, this.count);
    this.body.replaceChildren(...Array.from({ length: Math.max(end - first, 0) }, (_, place) =>
      this.made(first + place, scrollTop + (first + place - top) * ROW)));
  }

  made(number, top) {
    const text = this.lines.line(number);
    const made = element("div", { className: "log-line" }, element("i", {}, String(number + 1)));
    made.style.top = `${top}px`;
    this.lineOf.set(made, number);
    let at = 0;
    for (const { packet, begin, end } of this.lines.marks(number)) {
      const mark = element("b", { className: packet + FIRST === this.capture.number ? "chosen" : "" }, text.slice(begin, end));
      this.packetOf.set(mark, packet + FIRST);
      made.append(text.slice(at, begin), mark);
      at = end;
    }
    made.append(text.slice(at));
    return made;
  }

  follow() {
    const line = this.lines?.lineOf(this.capture.number - FIRST);
    if (line !== undefined) {
      const first = this.root.scrollTop * this.step, seen = this.root.clientHeight / ROW;
      if (line < first || line > first + seen - 2) this.root.scrollTop = (line - seen / 3) / this.step;
    }
    this.draw();
  }

  click({ target }) {
    const packet = this.packetOf.get(target) ?? this.firstIn(target.closest(".log-line"));
    if (packet) this.capture.goTo(packet);
  }

  // The first packet in a line.
  firstIn(row) {
    const [mark] = row ? this.lines.marks(this.lineOf.get(row)) : [];
    return mark && mark.packet + FIRST;
  }

  // Up and down go to the telegrams of the log, one by one.
  press(event) {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    const wanted = Math.max(this.capture.number + step, FIRST);
    if (wanted <= this.capture.packets) this.capture.goTo(wanted);
  }
}
