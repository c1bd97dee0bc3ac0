// SPDX-License-Identifier: GPL-2.0-or-later
// The lines of a log beside its telegrams. capture.log is {lines, places, ...}: of each packet, but the event at the
// beginning, the places of its bytes, [line, first column, end]. Chosen lines and packets light up both ways.

import { element } from "./dom.js";

const ROW = 22; // pixels, as in page.css
const MORE = 10;
const FIRST = 2; // packet 1 is the event

export class LogLines {
  constructor(capture) {
    this.capture = capture;
    this.body = element("div", { className: "log-body" });
    this.root = element("div", { className: "log", tabIndex: 0, role: "region", "aria-label": "Lines of the log",
      onscroll: () => this.draw(), onclick: (event) => this.click(event), onkeydown: (event) => this.press(event) }, this.body);
    capture.addEventListener("selected", () => this.follow());
    new ResizeObserver(() => this.draw()).observe(this.root);
  }

  begin() {
    const { log } = this.capture;
    this.ofLine = new Map(); // line: [{packet, begin, end}]
    log?.places.forEach((places, place) => {
      for (const [line, begin, end] of places) {
        if (!this.ofLine.has(line)) this.ofLine.set(line, []);
        this.ofLine.get(line).push({ packet: place + FIRST, begin, end });
      }
    });
    this.body.style.height = `${(log?.lines.length ?? 0) * ROW}px`;
    this.root.scrollTop = 0;
    this.draw();
  }

  draw() {
    const lines = this.capture.log?.lines ?? [];
    const first = Math.max(Math.floor(this.root.scrollTop / ROW) - MORE, 0);
    const end = Math.min(first + Math.ceil(this.root.clientHeight / ROW) + 2 * MORE, lines.length);
    this.body.replaceChildren(...Array.from({ length: Math.max(end - first, 0) }, (_, place) => this.line(first + place, lines)));
  }

  line(number, lines) {
    const text = lines[number], marks = [...(this.ofLine.get(number) ?? [])].sort((one, other) => one.begin - other.begin);
    const made = element("div", { className: "log-line" }, element("i", {}, String(number + 1)));
    made.style.top = `${number * ROW}px`;
    made.line = number;
    let at = 0;
    for (const { packet, begin, end } of marks) {
      const mark = element("b", { className: packet === this.capture.number ? "chosen" : "" }, text.slice(begin, end));
      mark.packet = packet;
      made.append(text.slice(at, begin), mark);
      at = end;
    }
    made.append(text.slice(at));
    return made;
  }

  follow() {
    const place = this.capture.log?.places[this.capture.number - FIRST]?.[0];
    if (place) {
      const top = place[0] * ROW, seen = this.root.clientHeight;
      if (top < this.root.scrollTop || top > this.root.scrollTop + seen - 2 * ROW) this.root.scrollTop = top - seen / 3;
    }
    this.draw();
  }

  click(event) {
    const packet = event.target.packet ?? this.ofLine.get(event.target.closest(".log-line")?.line)?.[0].packet;
    if (packet) this.capture.goTo(packet);
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
