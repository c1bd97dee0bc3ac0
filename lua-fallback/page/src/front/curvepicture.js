// SPDX-License-Identifier: GPL-2.0-or-later
// Draws a curve: a band from the least to the greatest value of each step, a line of their mean, dots where there is room.

import { shape } from "./svg.js";
import { ticks } from "./ticks.js";

const HEIGHT = 380, LEFT = 62, RIGHT = 12, TOP = 26, BOTTOM = 40; // pixels
const ROOM = 4; // pixels between values that have dots; those that are nearer are drawn together, so many pixels as one
const TICK = 110; // pixels between two times

export class CurvePicture {
  // `points` are [{time, count, least, mean, most}]; a value of a stepped curve holds until the next one.
  constructor({ points, step, zoom, title, isStepped }) {
    this.points = points;
    this.step = step;
    this.zoom = zoom;
    this.title = title;
    this.isStepped = isStepped;
    this.low = points.reduce((low, { least }) => Math.min(low, least), Infinity);
    this.high = points.reduce((high, { most }) => Math.max(high, most), -Infinity);
    const label = `${title} over time, from ${this.low} to ${this.high}`;
    if (this.low === this.high) [this.low, this.high] = [this.low - Math.abs(this.low) / 10 - 1e-9, this.high + Math.abs(this.high) / 10 + 1e-9];
    this.chosen = -1;
    this.svg = shape("svg", { class: "curve", role: "application", tabindex: 0, "aria-label": label });
    this.cursor = shape("circle", { r: 6, class: "cursor", visibility: "hidden" });
  }

  x(time) {
    return LEFT + ((time - this.zoom.from) / this.zoom.span) * (this.width - LEFT - RIGHT);
  }

  y(value) {
    return HEIGHT - BOTTOM - ((value - this.low) / (this.high - this.low)) * (HEIGHT - TOP - BOTTOM);
  }

  // The middle of a step, where its values are drawn.
  at({ time }) {
    return this.x(Math.min(time + this.step / 2, this.zoom.last));
  }

  part({ clientX }) {
    return (clientX - this.svg.getBoundingClientRect().left - LEFT) / (this.width - LEFT - RIGHT);
  }

  nearest(event) {
    const time = this.zoom.at(this.part(event)) - this.step / 2, { points } = this;
    let found = 0;
    points.forEach((point, place) => {
      if (Math.abs(point.time - time) < Math.abs(points[found].time - time)) found = place;
    });
    return found;
  }

  draw(width) {
    this.width = width;
    const { svg } = this, clip = shape("clipPath", { id: "curve-clip" });
    svg.setAttribute("width", width);
    svg.setAttribute("height", HEIGHT);
    clip.append(shape("rect", { x: LEFT, y: 0, width: Math.max(width - LEFT - RIGHT, 0), height: HEIGHT }));
    const inside = shape("g", { "clip-path": "url(#curve-clip)" });
    inside.append(...this.curve(), this.cursor);
    svg.replaceChildren(clip, ...this.axes(), inside);
    if (this.chosen >= 0) this.choose(this.chosen);
  }

  axes() {
    const { width, zoom } = this;
    const grid = (x1, x2, y1, y2) => shape("line", { x1, x2, y1, y2, class: "grid" });
    const values = ticks(this.low, this.high, 6).flatMap((value) => [grid(LEFT, width - RIGHT, this.y(value), this.y(value)),
      shape("text", { x: LEFT - 6, y: this.y(value) + 4, "text-anchor": "end" }, String(value))]);
    const times = ticks(zoom.from, zoom.to, (width - LEFT) / TICK).flatMap((time) => [grid(this.x(time), this.x(time), TOP, HEIGHT - BOTTOM),
      shape("text", { x: this.x(time), y: HEIGHT - BOTTOM + 18, "text-anchor": "middle" }, String(time))]);
    return [...values, ...times, shape("text", { x: LEFT, y: 14, class: "title" }, this.title),
      shape("text", { x: (width + LEFT) / 2, y: HEIGHT - 4, "text-anchor": "middle" }, "seconds since the first packet")];
  }

  curve() {
    const { zoom, points, step } = this, width = this.width - LEFT - RIGHT;
    const inside = points.filter(({ time }) => time >= zoom.from - step && time <= zoom.to);
    const before = points.findLast(({ time }) => time < zoom.from - step), after = points.find(({ time }) => time > zoom.to);
    const hasRoom = width / Math.max(inside.length, 1) > ROOM;
    const shown = [before, ...inside, after].filter(Boolean);
    const all = hasRoom ? shown : together(shown, Math.max(ROOM * (zoom.span / width), step), step);
    const path = (of) => all.map((point, place) => {
      if (!place) return `M${this.at(point)} ${this.y(point[of])}`;
      return this.isStepped ? `H${this.at(point)} V${this.y(point[of])}` : `L${this.at(point)} ${this.y(point[of])}`;
    }).join(" ");
    const drawn = [shape("path", { class: "band", d: this.band(all) }), shape("path", { class: "mean", d: path("mean") })];
    return hasRoom ? [...drawn, ...inside.map((point) => shape("circle", { cx: this.at(point), cy: this.y(point.mean), r: 2.6, class: "value" }))] : drawn;
  }

  // Out along the greatest values, back along the least.
  band(all) {
    const corners = (of) => all.flatMap((point, place) => (this.isStepped && place ? [[this.at(point), this.y(all[place - 1][of])]] : [])
      .concat([[this.at(point), this.y(point[of])]]));
    return `M${[...corners("most"), ...corners("least").reverse()].map((corner) => corner.join(" ")).join(" L")} Z`;
  }

  choose(place) {
    this.chosen = Math.min(Math.max(place, 0), this.points.length - 1);
    const point = this.points[this.chosen];
    this.cursor.setAttribute("cx", this.at(point));
    this.cursor.setAttribute("cy", this.y(point.mean));
    this.cursor.setAttribute("visibility", "visible");
    return point;
  }
}

// Points that are in the same `seconds` become one.
function together(points, seconds, step) {
  const found = new Map();
  for (const { time, count, least, mean, most } of points) {
    const at = Math.floor(time / seconds), sum = found.get(at);
    if (sum) {
      Object.assign(sum, { least: Math.min(sum.least, least), most: Math.max(sum.most, most),
        mean: (sum.mean * sum.count + mean * count) / (sum.count + count), count: sum.count + count });
    } else {
      found.set(at, { time: (at + 0.5) * seconds - step / 2, count, least, mean, most });
    }
  }
  return [...found.values()];
}
