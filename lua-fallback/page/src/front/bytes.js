// SPDX-License-Identifier: GPL-2.0-or-later
// The bytes of a packet, and of what Wireshark has put together from several. Those of the chosen field light up; a click
// on a byte, or the arrow keys, choose its field.

import { button, element, save } from "./dom.js";

const LINE = 16;
const MOST = 4096; // bytes that are shown at once

const hex = (value, digits = 2) => value.toString(16).padStart(digits, "0");
const printable = (byte) => (byte >= 0x20 && byte < 0x7f ? String.fromCharCode(byte) : "·");

export class Bytes {
  constructor(capture) {
    this.capture = capture;
    this.source = 0;
    this.cursor = 0;
    this.tabs = element("div", { className: "tabs" });
    this.dump = element("pre", { className: "dump", tabIndex: 0, "aria-label": "Bytes of the packet", role: "group",
      onclick: (event) => this.click(event), onkeydown: (event) => this.press(event) });
    this.root = element("div", { className: "bytes" }, this.tabs, this.dump);
    capture.addEventListener("selected", () => this.begin());
    capture.addEventListener("marked", () => this.showMark());
  }

  begin() {
    this.source = 0;
    this.limit = MOST;
    this.draw();
  }

  draw() {
    const sources = this.capture.packet?.sources ?? [];
    this.tabs.replaceChildren(...(sources.length < 2 ? [] : sources.map(({ name }, place) =>
      button(name.replace(/ \(\d+ bytes?\)$/, ""), () => this.show(place), { "aria-pressed": String(place === this.source) }))));
    if (sources.length > 1) this.tabs.append(button("Save these bytes", () => this.save()));
    this.cells = [];
    this.letters = [];
    const bytes = sources[this.source]?.bytes ?? new Uint8Array();
    this.dump.replaceChildren();
    for (let start = 0; start < Math.min(bytes.length, this.limit); start += LINE) this.dump.append(this.line(bytes, start));
    if (bytes.length > this.limit) {
      const more = () => {
        this.limit = Infinity;
        this.draw();
      };
      this.dump.append(button(`Show all ${bytes.length.toLocaleString("en")} bytes`, more));
    }
    this.showMark();
  }

  line(bytes, start) {
    const line = element("span", { className: "line" }, element("i", {}, hex(start, 4)), "  ");
    const letters = element("span", { className: "letters" });
    for (let place = start; place < start + LINE; place++) {
      if (place % 8 === 0 && place > start) line.append(" ");
      if (place >= bytes.length) {
        line.append("   ");
        continue;
      }
      const cell = element("b", {}, hex(bytes[place])), letter = element("b", {}, printable(bytes[place]));
      cell.place = letter.place = place;
      this.cells[place] = cell;
      this.letters[place] = letter;
      line.append(cell, " ");
      letters.append(letter);
    }
    line.append(" ", letters, "\n");
    return line;
  }

  show(place) {
    this.source = place;
    this.limit = MOST;
    this.draw();
  }

  showMark() {
    const { mark } = this.capture;
    if (mark && mark.source !== this.source && this.capture.packet?.sources[mark.source]) return this.show(mark.source);
    this.cells?.forEach((cell, place) => {
      const isMarked = Boolean(mark) && place >= mark.start && place < mark.start + mark.length;
      cell.classList.toggle("marked", isMarked);
      this.letters[place].classList.toggle("marked", isMarked);
    });
    if (!mark) return undefined;
    this.cursor = mark.start;
    const cell = this.cells[mark.start];
    if (cell && !isSeen(cell, this.dump)) this.dump.scrollTop = cell.offsetTop - this.dump.offsetTop - 24;
    return undefined;
  }

  choose(place) {
    if (!this.cells[place]) return;
    this.cursor = place;
    this.capture.mark = { start: place, length: 1, source: this.source };
    this.capture.marker = this;
    this.capture.tell("marked");
  }

  click(event) {
    if (event.target.place !== undefined) this.choose(event.target.place);
  }

  press(event) {
    const step = { ArrowRight: 1, ArrowLeft: -1, ArrowDown: LINE, ArrowUp: -LINE }[event.key];
    if (!step) return;
    event.preventDefault();
    const from = this.cursor;
    const end = this.capture.mark ? from + (step > 0 ? this.capture.mark.length - 1 : 0) : from;
    this.choose((step === 1 ? end : from) + step);
  }

  save() {
    const { name, bytes } = this.capture.packet.sources[this.source];
    save(`packet ${this.capture.number}, ${name.replace(/[^\w ,.-]/g, "_")}.bin`, bytes, "application/octet-stream");
  }
}

function isSeen(one, inside) {
  const box = one.getBoundingClientRect(), frame = inside.getBoundingClientRect();
  return box.top >= frame.top && box.bottom <= frame.bottom;
}
