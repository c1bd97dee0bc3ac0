// SPDX-License-Identifier: GPL-2.0-or-later
// The bytes of a packet, and of what Wireshark has put together from several. Those of the chosen field light up; a click
// on a byte, or the arrow keys, choose its field.

import { button, element, save } from "./dom.js";

const WIDE = 16, NARROW = 8; // bytes in a line
const OF_WIDE = 4 + 2 + 3 * WIDE + 2 + WIDE; // characters of such a line
const PORTION = 1024; // bytes that are shown at once
const TELEGRAM = /^Characters\b/; // what Wireshark calls the characters of a record of the tap; the rest is their envelope

const hex = (value, digits = 2) => value.toString(16).padStart(digits, "0");
const printable = (byte) => (byte >= 0x20 && byte < 0x7f ? String.fromCharCode(byte) : "·");

export class Bytes {
  constructor(capture) {
    this.capture = capture;
    this.source = 0;
    this.cursor = this.from = this.to = 0; // bytes from `from` to `to` are elements
    this.width = WIDE;
    this.marked = { begin: 0, end: 0 };
    this.places = new WeakMap(); // of bytes, by their elements
    this.tabs = element("div", { className: "tabs" });
    this.dump = element("pre", { className: "dump", tabIndex: 0, "aria-label": "Bytes of the packet", role: "group",
      onclick: (event) => this.click(event), onkeydown: (event) => this.press(event) });
    this.probe = element("i", { className: "probe", "aria-hidden": "true" }, "0".repeat(OF_WIDE));
    this.root = element("div", { className: "bytes" }, this.tabs, this.dump, this.probe);
    capture.addEventListener("selected", () => this.begin());
    capture.addEventListener("marked", () => this.showMark());
    new ResizeObserver(() => this.fit()).observe(this.dump);
  }

  get sources() {
    return this.capture.packet?.sources ?? [];
  }

  // The bytes that are shown.
  get bytes() {
    return this.sources[this.source]?.bytes ?? new Uint8Array();
  }

  begin() {
    this.show(Math.max(this.sources.findIndex(({ name }) => TELEGRAM.test(name)), 0));
  }

  // Shows a source: the portion that has the byte `at`.
  show(place, at = 0) {
    this.source = place;
    this.from = at - (at % PORTION);
    this.to = this.from + PORTION;
    this.draw();
  }

  // Shows a portion more, and keeps what is seen where it is.
  extend(isBefore) {
    const { scrollHeight, scrollTop } = this.dump;
    if (isBefore) this.from -= PORTION;
    else this.to += PORTION;
    this.draw();
    this.dump.scrollTop = scrollTop + (isBefore ? this.dump.scrollHeight - scrollHeight : 0);
  }

  // A narrow pane has shorter lines, so that the letters stay beside the bytes.
  fit() {
    const width = this.probe.offsetWidth > this.dump.clientWidth ? NARROW : WIDE;
    if (width === this.width) return;
    this.width = width;
    this.draw();
  }

  draw() {
    const { sources, bytes } = this;
    this.tabs.replaceChildren(...(sources.length < 2 ? [] : sources.map(({ name }, place) =>
      button(name.replace(/ \(\d+ bytes?\)$/, ""), () => this.show(place), { "aria-pressed": String(place === this.source) }))));
    if (sources.length > 1) this.tabs.append(button("Save these bytes", () => this.save()));
    this.cells = [];
    this.letters = [];
    this.marked = { begin: 0, end: 0 };
    const lines = [], end = Math.min(bytes.length, this.to);
    for (let start = this.from; start < end; start += this.width) lines.push(this.line(bytes, start));
    this.dump.replaceChildren(...this.more(this.from, true), ...lines, ...this.more(bytes.length - end, false));
    this.showMark();
  }

  more(count, isBefore) {
    const words = `Show more: ${count.toLocaleString("en")} bytes are ${isBefore ? "before" : "after"} these`;
    return count > 0 ? [button(words, () => this.extend(isBefore), { className: "small" }), "\n"] : [];
  }

  line(bytes, start) {
    const line = element("span", { className: "line" }, element("i", {}, hex(start, 4)), "  ");
    const letters = element("span", { className: "letters" });
    for (let place = start; place < start + this.width; place++) {
      if (place % 8 === 0 && place > start) line.append(" ");
      if (place >= bytes.length) {
        line.append("   ");
        continue;
      }
      const cell = element("b", {}, hex(bytes[place])), letter = element("b", {}, printable(bytes[place]));
      for (const made of [cell, letter]) this.places.set(made, place);
      this.cells[place] = cell;
      this.letters[place] = letter;
      line.append(cell, " ");
      letters.append(letter);
    }
    line.append(" ", letters, "\n");
    return line;
  }

  showMark() {
    const { mark } = this.capture;
    if (mark && this.isElsewhere(mark)) return this.show(mark.source, mark.start);
    this.light(mark ? { begin: mark.start, end: mark.start + mark.length } : { begin: 0, end: 0 });
    if (!mark) return undefined;
    this.cursor = mark.start;
    const cell = this.cells?.[mark.start];
    if (cell && !isSeen(cell, this.dump)) this.dump.scrollTop = cell.offsetTop - this.dump.offsetTop - 24;
    return undefined;
  }

  isElsewhere({ source, start }) {
    const bytes = this.sources[source]?.bytes;
    return Boolean(bytes) && start < bytes.length && (source !== this.source || start < this.from || start >= this.to);
  }

  // Touches only what changes.
  light(wanted) {
    const { marked, cells = [], letters } = this;
    const turn = (one, other, isMarked) => {
      for (let place = Math.max(one.begin, this.from); place < Math.min(one.end, cells.length); place++) {
        if (place >= other.begin && place < other.end) continue;
        cells[place].classList.toggle("marked", isMarked);
        letters[place].classList.toggle("marked", isMarked);
      }
    };
    turn(marked, wanted, false);
    turn(wanted, marked, true);
    this.marked = wanted;
  }

  choose(place) {
    if (place < 0 || place >= this.bytes.length) return;
    this.cursor = place;
    this.capture.mark = { start: place, length: 1, source: this.source };
    this.capture.marker = this;
    this.capture.tell("marked");
  }

  click(event) {
    const place = this.places.get(event.target);
    if (place !== undefined) this.choose(place);
  }

  // Chooses the byte there, unless it is among the chosen ones.
  chooseAt(target) {
    const place = this.places.get(target), { begin, end } = this.marked;
    if (place !== undefined && !(place >= begin && place < end)) this.choose(place);
  }

  // Those of the chosen field, or all that the tab shows.
  chosenBytes() {
    const { begin, end } = this.marked;
    return end > begin ? this.bytes.subarray(begin, end) : this.bytes;
  }

  get cursorCell() {
    return this.cells[this.cursor];
  }

  // The line of the dump in which the chosen byte is.
  rowText() {
    return this.cursorCell?.parentElement.textContent.trimEnd() ?? "";
  }

  press(event) {
    const step = { ArrowRight: 1, ArrowLeft: -1, ArrowDown: this.width, ArrowUp: -this.width }[event.key];
    if (!step || event.altKey || event.ctrlKey) return;
    event.preventDefault();
    const from = this.cursor;
    const end = this.capture.mark ? from + (step > 0 ? this.capture.mark.length - 1 : 0) : from;
    this.choose((step === 1 ? end : from) + step);
  }

  save() {
    const { name } = this.sources[this.source];
    save(`packet ${this.capture.number}, ${name.replace(/[^\w ,.-]/g, "_")}.bin`, this.bytes, "application/octet-stream");
  }
}

function isSeen(one, inside) {
  const box = one.getBoundingClientRect(), frame = inside.getBoundingClientRect();
  return box.top >= frame.top && box.bottom <= frame.bottom;
}
