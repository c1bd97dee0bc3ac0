// SPDX-License-Identifier: GPL-2.0-or-later
// Something that is heard now: the bus that plays, or a port. Its blocks become a file, its last records the packet list.

import { button, element, find, save } from "./dom.js";
import { callTap } from "./tap.js";

const STEP_MS = 200;
const SHOW_MS = 1000; // how often the list is renewed, at least this long apart ...
const EASE = 4; // ... and this many times what renewing takes
const TOGETHER = 1 << 20; // bytes that are kept in memory before the browser may put them elsewhere
const LARGEST = 200_000_000; // bytes of a capture that is opened at its end

export class Live {
  // `source`: {title, name, controls, preferences, next(), close()}; next returns {chunk, said, isOver}, close what is not stepped yet.
  constructor(capture, source, file = null) {
    this.capture = capture;
    this.source = source;
    this.file = file; // where the blocks go, if a person has named a file
    this.parts = [];
    this.chunks = [];
    this.leftOut = 0;
    this.isOver = false;
    this.said = element("span", { role: "status" });
    this.bar = element("div", { className: "live-bar" }, element("b", {}, source.title), this.said, ...source.controls,
      button("Stop", () => this.stop()));
  }

  stop() {
    this.isOver = true;
    return this.ended;
  }

  // Runs until it is stopped; then the whole capture is open.
  async run() {
    await this.capture.live?.stop();
    await this.capture.prefer(this.source.preferences ?? this.capture.kept);
    this.capture.live = this;
    this.ended = this.runOn().finally(() => (this.capture.live = null));
    return this.ended;
  }

  async runOn() {
    find("#live").replaceChildren(this.bar);
    this.capture.isFollowing = true;
    let shown = 0, took = 0, isNew = true;
    try {
      while (!this.isOver) {
        const { chunk, said, isOver } = await this.source.next();
        this.keep(chunk);
        isNew ||= chunk.length > 0;
        this.said.textContent = said;
        this.isOver ||= isOver;
        if (isNew && performance.now() - shown > Math.max(SHOW_MS, EASE * took)) {
          const begin = performance.now();
          await this.show();
          shown = performance.now();
          took = shown - begin;
          isNew = false;
        }
        await new Promise((resolve) => setTimeout(resolve, STEP_MS));
      }
    } finally {
      await this.end().finally(() => find("#live").replaceChildren());
    }
  }

  keep(chunk) {
    if (!chunk.length) return;
    if (this.file) {
      this.file.write(chunk);
      return;
    }
    this.chunks.push(chunk);
    if (this.chunks.reduce((sum, { length }) => sum + length, 0) < TOGETHER) return;
    this.parts.push(new Blob(this.chunks));
    this.chunks = [];
  }

  async show() {
    const { bytes, leftOut } = await callTap("window", []);
    await this.capture.renew(this.source.name, bytes, leftOut - this.leftOut);
    this.leftOut = leftOut;
  }

  async end() {
    const rest = await this.source.close?.();
    if (rest?.length) this.keep((await callTap("step", [rest])).chunk);
    await this.show();
    this.keep(await callTap("end", []));
    if (this.file) {
      await this.file.close();
      return undefined;
    }
    const whole = new Blob([...this.parts, ...this.chunks]);
    if (whole.size > LARGEST) return this.saveAway(whole);
    const { filter, isFollowing, preferences } = this.capture;
    const number = this.leftOut || isFollowing ? 0 : this.capture.number;
    await this.capture.open(this.source.name, new Uint8Array(await whole.arrayBuffer()), { filter, number, preferences });
    return undefined;
  }

  saveAway(whole) {
    save(this.source.name, whole);
    const size = Math.round(whole.size / 1e6).toLocaleString("en");
    this.capture.note(`The whole capture, ${size} MB, was saved as ${this.source.name}: open it in Wireshark. The list has its last records.`);
  }
}
