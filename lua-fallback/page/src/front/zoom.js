// SPDX-License-Identifier: GPL-2.0-or-later
// The part of a picture's time that is seen. Wheel, pointer and keys zoom and move it, in all pictures alike.

const MOST = 1e6; // times the whole
const WHEEL = 1.002; // for each pixel that a wheel turns
const LINE = 16, PAGE = 400; // pixels, where a wheel counts otherwise
const KEY = 1.6, KEY_MOVES = 0.2;
const CLICK = 4; // pixels that a pointer may move in a click

export class Zoom {
  constructor(onchange) {
    this.onchange = onchange;
    this.setWhole(0, 1);
  }

  setWhole(first, last) {
    this.first = this.from = first;
    this.last = this.to = last;
  }

  get span() {
    return this.to - this.from;
  }

  get isAll() {
    return this.from === this.first && this.to === this.last;
  }

  // Shows a part, as far as there is something.
  show(from, to) {
    const { first, last } = this, whole = last - first;
    const span = Math.min(Math.max(to - from, whole / MOST), whole);
    this.from = Math.min(Math.max(from, first), last - span);
    this.to = this.from + span;
    this.onchange();
  }

  // Makes what is seen so many times as wide. `at` stays where it is.
  by(factor, at = (this.from + this.to) / 2) {
    const from = at - (at - this.from) * factor;
    this.show(from, from + this.span * factor);
  }

  // Moves by a part of what is seen.
  move(part) {
    this.show(this.from + part * this.span, this.to + part * this.span);
  }

  all() {
    this.show(this.first, this.last);
  }

  at(part) {
    return this.from + part * this.span;
  }
}

const KEYS = {
  "+": (zoom) => zoom.by(1 / KEY), "=": (zoom) => zoom.by(1 / KEY), "-": (zoom) => zoom.by(KEY), 0: (zoom) => zoom.all(),
  ArrowLeft: (zoom) => zoom.move(-KEY_MOVES), ArrowRight: (zoom) => zoom.move(KEY_MOVES),
};

// Returns whether a key has changed what is seen.
export function pressed(zoom, { key, altKey, ctrlKey, metaKey }) {
  if (altKey || ctrlKey || metaKey || !Object.hasOwn(KEYS, key)) return false;
  KEYS[key](zoom);
  return true;
}

// Lets wheel and pointers change what is seen. `part` says where an event is in the picture's width, from 0 to 1;
// `onclick` is called for what was no drag.
export function follow(root, zoom, { part, onclick }) {
  const pointers = new Map(); // id: {x, at}; at is the time below it when it came
  let moved = 0;
  root.addEventListener("wheel", (event) => {
    event.preventDefault();
    const unit = [1, LINE, PAGE][event.deltaMode], x = event.deltaX * unit, y = event.deltaY * unit;
    if (event.shiftKey || Math.abs(x) > Math.abs(y)) zoom.move((x || y) / root.clientWidth);
    else zoom.by(WHEEL ** y, zoom.at(part(event)));
  }, { passive: false });
  root.addEventListener("pointerdown", (event) => {
    if (event.button) return;
    root.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, { x: event.clientX, part: part(event), at: zoom.at(part(event)) });
    moved = pointers.size > 1 ? CLICK : 0;
  });
  root.addEventListener("pointermove", (event) => {
    const pointer = pointers.get(event.pointerId);
    if (!pointer) return;
    moved = Math.max(moved, Math.abs(event.clientX - pointer.x));
    pointer.part = part(event);
    if (moved >= CLICK) drag(zoom, ...pointers.values());
  });
  const end = (event) => {
    if (!pointers.delete(event.pointerId)) return;
    for (const pointer of pointers.values()) pointer.at = zoom.at(pointer.part);
    if (event.type === "pointerup" && moved < CLICK) onclick(event);
  };
  root.addEventListener("pointerup", end);
  root.addEventListener("pointercancel", end);
  root.addEventListener("dblclick", () => zoom.all());
}

// What was below one pointer stays below it; of two, both.
function drag(zoom, one = null, other = null) {
  const apart = other ? other.part - one.part : 0;
  const span = apart ? (other.at - one.at) / apart : zoom.span;
  if (span > 0) zoom.show(one.at - one.part * span, one.at + (1 - one.part) * span);
}
