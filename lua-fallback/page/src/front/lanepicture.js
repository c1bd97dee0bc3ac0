// SPDX-License-Identifier: GPL-2.0-or-later
// Draws the lanes: each column of pixels shows the worst of what it stands for.

import { ticks } from "./ticks.js";
import { COMMAND, FAULT, OTHER, REACTION } from "./records.js";

export const LABELS = 74; // pixels to the left of time
const AXIS = 15, LANE = 13, MOST = 90, LEAST = 4; // pixels: of the axis, of a lane, of all lanes, of one among many
const TEXT = 11; // pixels that a label needs
const TICK = 90; // pixels between two times
const BAND = 3, SILENCE = 5; // pixels at least
const FAULT_PIXELS = 2;
const FONT = "10.5px system-ui, sans-serif";

// Where in its lane a bar is, from 0 to 1: what is wrong is tall, so that it is seen without colours, too.
const BARS = { [OTHER]: [0.4, 0.7, "--faint"], [REACTION]: [0.4, 0.92, "--lane-reaction"], [COMMAND]: [0.2, 0.72, "--link"], [FAULT]: [0, 1, "--wrong"] };
const BANDS = { error: "--lane-error", warning: "--lane-warning", note: "--lane-note" };

export class LanePicture {
  constructor(canvas, records, zoom) {
    this.canvas = canvas;
    this.records = records;
    this.zoom = zoom;
    const { length } = records.lanes;
    this.lane = Math.max(Math.min(LANE, MOST / length), LEAST);
    this.height = Math.ceil(length * this.lane) + AXIS;
    this.bands = [];
  }

  // `seen` are the first and the last number of the packet list; `began` is the time of the first packet.
  draw({ width, selected, episodes, began, seen }) {
    this.size(width);
    this.bands = episodes.map((one) => ({ ...one, first: Date.parse(one.from) / 1000 - began, last: Date.parse(one.to) / 1000 - began }));
    const style = getComputedStyle(this.canvas);
    this.colour = (name) => style.getPropertyValue(name);
    this.drawBands();
    this.drawAxis(seen);
    this.records.lanes.forEach((lane, number) => this.drawLane(lane, number));
    this.drawSelected(selected);
    this.drawLabels();
  }

  size(width) {
    const { canvas, height } = this;
    this.ratio = devicePixelRatio;
    this.width = width;
    canvas.width = Math.round(width * this.ratio);
    canvas.height = Math.round(height * this.ratio);
    canvas.style.width = `${width}px`;
    canvas.style.height = `${height}px`;
    this.pen = canvas.getContext("2d");
    this.pen.scale(this.ratio, this.ratio);
    this.pen.font = FONT;
    this.pen.textBaseline = "middle";
  }

  // Seconds of a pixel.
  get perPixel() {
    return this.zoom.span / Math.max(this.width - LABELS, 1);
  }

  x(time) {
    return LABELS + (time - this.zoom.from) / this.perPixel;
  }

  top(number) {
    return AXIS + number * this.lane;
  }

  laneAt(y) {
    return y < AXIS ? undefined : this.records.lanes[Math.floor((y - AXIS) / this.lane)];
  }

  // A time as text, as exact as a pixel is.
  seconds(time) {
    return `${time.toFixed(Math.min(Math.max(Math.ceil(-Math.log10(this.perPixel)), 0), 6))} s`;
  }

  isOf({ station, stations = [] }, lane) {
    const all = station === null || station === undefined ? stations : [station, ...stations];
    return !all.length || all.includes(lane.station);
  }

  bandsAt(time, lane) {
    const least = (BAND * this.perPixel) / 2;
    return lane ? this.bands.filter((band) => band.first - least <= time && time <= band.last + least && this.isOf(band, lane)) : [];
  }

  drawBands() {
    const { pen, lane: height } = this;
    for (const band of [...this.bands].reverse()) { // the worst is last, above the others
      const from = Math.max(this.x(band.first), LABELS), to = Math.min(Math.max(this.x(band.last), this.x(band.first) + BAND), this.width);
      if (to <= from) continue;
      pen.fillStyle = this.colour(BANDS[band.severity] ?? BANDS.note);
      this.records.lanes.forEach((lane, number) => this.isOf(band, lane) && pen.fillRect(from, this.top(number), to - from, height));
    }
  }

  drawAxis(seen) {
    const { pen, zoom, width } = this;
    pen.fillStyle = this.colour("--faint");
    pen.textAlign = "center";
    for (const time of ticks(zoom.from, zoom.to, (width - LABELS) / TICK)) {
      pen.fillRect(this.x(time), AXIS - 4, 1, 4);
      if (this.x(time) > LABELS + 15 && this.x(time) < width - 25) pen.fillText(`${time} s`, this.x(time), 6);
    }
    pen.fillRect(LABELS, AXIS - 1, width - LABELS, 1);
    const [from, to] = seen?.map((number) => this.records.placeOf(number)) ?? [-1, -1];
    if (from < 0 || to < 0) return;
    const first = this.x(this.records.times[from]), last = Math.max(this.x(this.records.times[to]), first + 2);
    pen.fillStyle = this.colour("--ink");
    if (last > LABELS) pen.fillRect(Math.max(first, LABELS), AXIS - 3, last - Math.max(first, LABELS), 3);
  }

  // Fills the columns, in pixels of the screen, and draws those that are alike and side by side as one bar.
  drawLane({ places, silences }, number) {
    const { records, zoom, ratio } = this;
    const scale = ratio / this.perPixel, size = Math.ceil((this.width - LABELS) * ratio), columns = new Uint8Array(size);
    for (let at = records.after(places, zoom.from - records.longest); at < places.length; at++) {
      const place = places[at], begin = (records.times[place] - zoom.from) * scale;
      if (begin >= size) break;
      const level = records.levels[place], end = Math.min(Math.max(begin + records.lasts[place] * scale, begin + 1), size);
      for (let column = Math.max(Math.floor(begin), 0); column < end; column++) if (columns[column] < level) columns[column] = level;
    }
    this.pen.fillStyle = this.colour("--line");
    this.pen.fillRect(LABELS, this.top(number + 1) - 0.5, this.width - LABELS, 0.5);
    for (const level of [OTHER, REACTION, COMMAND, FAULT]) this.drawBars(columns, level, this.top(number));
    this.drawSilences(silences, this.top(number));
  }

  drawBars(columns, level, top) {
    const { pen, ratio, lane } = this;
    const [from, to, colour] = BARS[level], least = level === FAULT ? FAULT_PIXELS : 0;
    pen.fillStyle = this.colour(colour);
    pen.beginPath();
    for (let begin = columns.indexOf(level); begin >= 0; ) {
      let end = begin + 1;
      while (columns[end] === level) end++;
      pen.rect(LABELS + begin / ratio, top + from * lane, Math.max((end - begin) / ratio, least), (to - from) * lane);
      begin = columns.indexOf(level, end);
    }
    pen.fill();
  }

  // Hollow marks, at most one at a place.
  drawSilences(silences, top) {
    const { pen, records, zoom, lane } = this;
    pen.strokeStyle = this.colour("--wrong");
    pen.lineWidth = 1;
    for (let at = records.after(silences, zoom.from), drawn = -SILENCE; at < silences.length; at++) {
      const x = Math.round(this.x(records.times[silences[at]]));
      if (x > this.width) break;
      if (x < drawn + SILENCE) continue;
      pen.strokeRect(x + 0.5, top + 1.5, SILENCE - 1, lane - 3);
      drawn = x;
    }
  }

  drawSelected(number) {
    const { pen, records, height } = this, place = records.placeOf(number);
    if (place < 0) return;
    const x = this.x(records.times[place]);
    if (x < LABELS || x > this.width) return;
    pen.fillStyle = this.colour("--ink");
    pen.fillRect(x - 0.75, 0, 1.5, height);
    pen.beginPath();
    pen.moveTo(x - 5, 0);
    pen.lineTo(x + 5, 0);
    pen.lineTo(x, 7);
    pen.fill();
  }

  // Names of the lanes, as many as there is room for.
  drawLabels() {
    const { pen, lane, records } = this, step = Math.ceil(TEXT / lane);
    pen.fillStyle = this.colour("--ink");
    pen.textAlign = "left";
    records.lanes.forEach(({ name }, number) => number % step === 0 && pen.fillText(name, 6, this.top(number) + Math.max(lane, TEXT) / 2 + 0.5, LABELS - 10));
  }
}
