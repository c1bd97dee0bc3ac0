// SPDX-License-Identifier: GPL-2.0-or-later
// Something that is heard now: the bus that plays, or a port. Its blocks become a file, its last records the packet list.

import { keepAwake } from "./awake.js";
import { button, element, find, save } from "./dom.js";
import { InMemory } from "./keeping.js";
import { callTap } from "./tap.js";

const STEP_MS = 200;
const SHOW_MS = 1000; // how often the list is renewed, at least this long apart ...
const EASE = 4; // ... and this many times what renewing takes
const LARGEST = 200_000_000; // bytes of a capture that is opened at its end

export class Live {
  // `source`: {title, name, controls, preferences, next(), close()}; next returns {chunk, said, isOver}, close what is not stepped yet.
  // `kept` is where the blocks go, see keeping.js; `file` is one that a person has named for them, open to write, or null.
  /** @param {any} capture
   * @param {any} source
   * @param {{kept?: any, file?: any}} options */
  constructor(capture, source, { kept = new InMemory(), file = null } = {}) {
    this.capture = capture;
    this.source = source;
    this.kept = kept;
    this.file = file;
    this.isBroken = false; // nothing more can be kept
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
    const sleep = keepAwake();
    this.ended = this.runOn().finally(() => {
      sleep();
      this.capture.live = null;
    });
    return this.ended;
  }

  async runOn() {
    find("#live").replaceChildren(this.bar);
    this.capture.isFollowing = true;
    let shown = 0, took = 0, isNew = true;
    try {
      while (!this.isOver) {
        const { chunk, said, isOver } = await this.source.next();
        await this.keep(chunk);
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

  async keep(chunk) {
    if (this.isBroken) return;
    try {
      await this.kept.add(chunk);
      if (chunk.length) await this.file?.write(chunk).catch(({ message }) => {
        throw new Error(`The file cannot be written: ${message}. Listening has ended. What came until then is open: export it`);
      });
    } catch (error) {
      this.isBroken = true;
      throw error;
    }
  }

  async show() {
    const { bytes, leftOut } = await callTap("window", []);
    await this.capture.renew(this.source.name, bytes, leftOut - this.leftOut);
    this.leftOut = leftOut;
  }

  async end() {
    const rest = await this.source.close?.();
    if (rest?.length) await this.keep((await callTap("step", [rest])).chunk);
    await this.show();
    await this.keep(await callTap("end", []));
    if (this.file && !this.isBroken) {
      await this.file.close();
    } else {
      const { filter, preferences } = this.capture;
      const number = this.capture.number + this.leftOut; // what was looked at
      const said = await openWhole(this.capture, this.source.name, await this.kept.whole(), { filter, number, preferences });
      if (said) this.capture.note(`${said} The list has its last records.`);
    }
    if (!this.isBroken) await this.kept.drop();
  }
}

// Opens a capture that was heard; saves one that is too large for the page, and says so.
export async function openWhole(capture, name, whole, options) {
  if (whole.size <= LARGEST) {
    await capture.open(name, new Uint8Array(await whole.arrayBuffer()), options);
    return "";
  }
  save(name, whole);
  return `The whole capture, ${Math.round(whole.size / 1e6).toLocaleString("en")} MB, was saved as ${name}: open it in Wireshark.`;
}
