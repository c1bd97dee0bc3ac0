// SPDX-License-Identifier: GPL-2.0-or-later
// A line of time with the characters of packets as boxes.

import { shape } from "../front/svg.js";

const WIDTH = 680, LEGIBLE = 17, TOP = 34, HEIGHT = 40, LANE = 62, LEFT = 24, RIGHT = 24;
const ROOM = WIDTH - LEFT - RIGHT;
const STEPS_MS = [0.5, 1, 2, 5, 10, 20, 50, 100, 200], MOST_STEPS = 14;
const MS = 1e6; // in ns
const STEP_NS = 0.1 * MS, LARGE_STEP_NS = MS; // of the arrow keys
const FAULTY = 2 | 4 | 8; // flags

export const hex = (byte) => byte.toString(16).toUpperCase().padStart(2, "0");

// Draws Characters; `chosen` is the id of one. `acts` are choose(one) and move(one, ns).
export function picture(characters, chosen, acts) {
  const { lanes, numbers } = characters;
  const scale = scaleOf(characters), bottom = TOP + LANE * lanes.length;
  const svg = shape("svg", { viewBox: `0 0 ${WIDTH} ${bottom + 12}`, class: "timeline", role: "group", "aria-label": "Characters of the packet" });
  svg.append(...axis(scale, bottom));
  lanes.forEach((lane, row) => {
    const y = TOP + LANE * row;
    svg.append(shape("text", { x: LEFT, y: y - 6, class: "lane" }, `packet ${numbers[row]}`), ...uncertain(characters, row, scale, y),
      ...lane.map((one) => box(characters, one, { scale, y, isChosen: one.id === chosen, ...acts })));
  });
  return svg;
}

// From ns to places in the picture. It begins with the first character's beginning.
function scaleOf({ lanes, widthNs }) {
  const begin = lanes[0][0].end - BigInt(Math.round(widthNs));
  const at = (end) => Number(end - begin);
  const spanNs = Math.max(...lanes.map((lane) => at(lane.at(-1).end))) * 1.04;
  return { at, spanNs, x: (ns) => LEFT + (ns / spanNs) * ROOM };
}

function axis({ spanNs, x }, bottom) {
  const step = STEPS_MS.find((ms) => spanNs / MS / ms < MOST_STEPS) ?? STEPS_MS.at(-1);
  const times = Array.from({ length: Math.ceil(spanNs / MS / step) }, (_, place) => place * step);
  return times.flatMap((ms) => [
    shape("line", { x1: x(ms * MS), x2: x(ms * MS), y1: TOP - 12, y2: bottom, class: "grid" }),
    shape("text", { x: x(ms * MS), y: 12, "text-anchor": "middle", class: "scale" }, `${ms} ms`),
  ]);
}

// Where the end of the character with the longest interval can have been.
function uncertain(characters, row, { at, x }, y) {
  const longest = characters.longest(row), ns = characters.uncertaintyNs(row);
  if (!longest || !ns) return [];
  const end = at(longest.end);
  return [shape("rect", { x: x(end - ns), width: x(end + ns) - x(end - ns), y: y - 4, height: HEIGHT + 8, class: "uncertain" })];
}

function box(characters, one, { scale: { at, x, spanNs }, y, isChosen, choose, move }) {
  const [value, interval, flags] = ["value", "interval", "flags"].map((which) => characters.get(one, which));
  const end = at(one.end), begin = x(end - characters.widthNs), wide = x(end) - begin;
  const group = shape("g", { tabindex: 0, role: "button", "data-character": one.id,
    class: `box${flags & FAULTY ? " faulty" : ""}${isChosen ? " chosen" : ""}`,
    "aria-label": `Character ${one.place + 1}, ${hex(value)}, after ${(interval / MS).toFixed(3)} ms` });
  group.append(shape("rect", { x: begin, width: Math.max(wide - 1, 2), y, height: HEIGHT, rx: 2 }));
  if (wide > LEGIBLE) group.append(shape("text", { x: begin + wide / 2, y: y + 25, "text-anchor": "middle" }, hex(value)));
  group.addEventListener("focus", () => choose(one));
  group.addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    move(one, step * (event.shiftKey ? LARGE_STEP_NS : STEP_NS));
  });
  group.addEventListener("pointerdown", (event) => {
    event.preventDefault();
    choose(one);
    drag(event, (pixels, pictureWidth) => move(one, (pixels * WIDTH * spanNs) / (pictureWidth * ROOM)));
  });
  return group;
}

// Follows the pointer until it is let go; each move draws the picture anew.
function drag({ clientX, currentTarget }, move) {
  const { width } = currentTarget.ownerSVGElement.getBoundingClientRect();
  let from = clientX;
  const follow = (event) => {
    move(event.clientX - from, width);
    from = event.clientX;
  };
  addEventListener("pointermove", follow);
  addEventListener("pointerup", () => removeEventListener("pointermove", follow), { once: true });
}
