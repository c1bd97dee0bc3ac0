// SPDX-License-Identifier: GPL-2.0-or-later
// The capture that is open: its rows under the present filter, and the selected packet. Views listen to its events:
// "opened", "noted", "closed", "filtered", "sorted", "rows", "selected", "marked", "judged", "busy".

import { LARGEST, USUAL, forFigures } from "../dissect/dissector.js";
import { startWireshark } from "./engine.js";
import { everyRow } from "./everyrow.js";
import { sorted } from "./sorting.js";

const BLOCK = 64; // rows that are fetched at once

export class Capture extends EventTarget {
  constructor() {
    super();
    this.viewer = this.watched(startWireshark());
    this.preferences = {}; // in force
    this.kept = {}; // those that a person has set, for the next capture, too
    this.memory = 0; // bytes of the first Wireshark's
    this.live = null; // a Live, while something is heard
    this.forget();
  }

  forget() {
    this.name = "";
    this.bytes = null;
    this.log = null; // lines of a log, and where its telegrams stand
    this.imported = null; // a recording of another tool, and what was said of it
    this.packets = 0;
    this.trouble = "";
    this.filter = "";
    this.matched = 0;
    this.number = 0; // of the selected packet
    this.packet = null;
    this.blocks = new Map();
    this.sort = null; // {column, isDown}: the place of a column
    this.order = null; // of a sorted list: {rows, places} by the number of the packet
    this.fetching = false;
    this.wanted = null;
    this.isFollowing = false; // of a capture that grows, whether its end is shown
    this.dropFigures();
  }

  // Of a Wireshark that breaks down, another one takes the place. It opens the capture again; what cannot be opened is
  // not open then.
  watched(starting) {
    const replace = () => {
      this.viewer = this.watched(startWireshark());
      if (this.isOpen) {
        const { name, bytes, log, imported, number, preferences } = this;
        this.open(name, bytes, { log, imported, number, preferences }).catch(() => {});
      } else {
        this.forget();
        this.tell("closed");
      }
    };
    starting.then((viewer) => (viewer.onbroken = replace), () => {});
    return starting;
  }

  dropFigures() {
    this.found = null; // what `sistap report` says, as judging.js has it, and its page
    this.page = null;
    this.figuresFound = null;
    this.counter?.then((peer) => peer.end());
    this.counter = null; // a promise of the second Wireshark
    this.counted = null; // a promise: it has the capture open
  }

  get isOpen() {
    return this.bytes !== null;
  }

  // The name of a file with the capture.
  get bytesName() {
    return this.log || this.imported ? `${this.name}.pcapng` : this.name;
  }

  // Says something about what is open.
  note(text) {
    this.trouble = text;
    this.tell("noted");
  }

  tell(name) {
    this.dispatchEvent(new Event(name));
  }

  // Does something that takes long; "busy" says so. `work` gets {signal, progress}: the signal if a person cancels it.
  async long(words, work) {
    const cancel = new AbortController();
    const busy = { words, part: 0, cancel: () => cancel.abort() };
    this.busy = busy;
    this.tell("busy");
    const progress = (part) => {
      busy.part = part;
      this.tell("busy");
    };
    try {
      return await work({ signal: cancel.signal, progress });
    } finally {
      if (this.busy === busy) this.busy = null;
      this.tell("busy");
    }
  }

  // Asks Wireshark something that takes long. To cancel it, another Wireshark takes its place, and opens `after`.
  async ask(words, name, args, after = null) {
    return this.long(words, async ({ signal, progress }) => {
      const viewer = await this.viewer;
      signal.addEventListener("abort", () => {
        viewer.end();
        this.viewer = this.watched(startWireshark());
        if (after) this.open(after.name, after.bytes, after);
      });
      return viewer.call(name, args, { progress });
    });
  }

  // Sets what counts from the next capture on.
  async prefer(preferences) {
    this.preferences = preferences;
    await (await this.viewer).call("prefer", [{ ...USUAL, ...preferences }]);
  }

  // Opens a capture of Wireshark. `log` and `imported`: see remarks.js. `filter` and `number` are kept when it is opened again.
  async open(name, bytes, { log = null, imported = null, filter = "", number = 0, preferences = this.kept } = {}) {
    if (this.memory > LARGEST) await this.replaceViewer();
    await this.prefer(preferences);
    this.forget();
    const about = await this.ask(`Opening ${name}`, "open", [bytes]);
    this.memory = about.memory;
    Object.assign(this, { name, bytes, log, imported, packets: about.packets, seconds: about.seconds, link: about.link });
    this.trouble = about.trouble;
    this.matched = about.packets;
    this.tell("opened");
    if (filter) await this.showOnly(filter).catch(() => this.showOnly(""));
    else this.tell("filtered");
    await this.select(number && number <= this.packets ? number : (await this.numberAt(0)));
  }

  // Shows the next state of a capture that grows: `leftOut` more packets than before are no longer in it. The selected
  // packet stays; at the end of the list, the end is followed.
  async renew(name, bytes, leftOut) {
    const { filter, number, isFollowing } = this;
    if (this.memory > LARGEST) await this.replaceViewer();
    const viewer = await this.viewer;
    const about = await viewer.call("open", [bytes]);
    this.memory = about.memory;
    Object.assign(this, { name, bytes, log: null, imported: null, packets: about.packets, seconds: about.seconds, link: about.link, trouble: "" });
    this.dropFigures();
    this.sort = this.order = null;
    const { matched, rows } = await viewer.call("rows", [filter, 0, BLOCK]);
    this.matched = matched;
    this.blocks = new Map([[0, rows]]);
    this.tell("grown");
    if (isFollowing) await this.select(await this.numberAt(matched - 1));
    else if (leftOut) await this.select(Math.max(number - leftOut, 0));
  }

  async replaceViewer() {
    const next = await startWireshark();
    await next.call("prefer", [{ ...USUAL, ...this.preferences }]);
    (await this.viewer).end();
    this.viewer = this.watched(Promise.resolve(next));
    this.memory = 0;
  }

  // Uses a display filter; throws Wireshark's words if it is not valid. A packet that it hides is not selected any longer.
  async setFilter(filter) {
    await this.showOnly(filter);
    const { number } = this;
    const isSeen = number > 0 && (await this.numberAt(await this.placeOf(number))) === number;
    if (!isSeen) await this.select(await this.numberAt(0));
  }

  async showOnly(filter) {
    const { name, bytes, log, imported, number } = this;
    const { matched, rows } = await this.ask("Filtering", "rows", [filter, 0, BLOCK], { name, bytes, log, imported, number });
    this.filter = filter;
    this.matched = matched;
    this.blocks = new Map([[0, rows]]);
    this.order = null;
    if (this.sort) await this.sortBy(this.sort).catch(() => (this.sort = null)); // cancelled
    this.tell("filtered");
  }

  // Sorts the rows that the filter leaves; null: as they were captured. It needs all of them.
  async sortBy(sort) {
    const { blocks, filter } = this;
    const order = sort && await this.long("Sorting", async (options) => {
      const all = [];
      for await (const row of everyRow(await this.viewer, filter, options)) all.push(row);
      const rows = sorted(all, sort.column, sort.isDown);
      return { rows, places: new Map(rows.map(({ number }, place) => [number, place])) };
    });
    if (blocks !== this.blocks) return; // another filter, or another capture
    this.sort = sort;
    this.order = order;
    this.tell("sorted");
  }

  // Returns a row by its place under the filter, or null; then it is fetched, and "rows" says when it is there.
  row(place) {
    if (this.order) return this.order.rows[place] ?? null;
    const block = Math.floor(place / BLOCK);
    const rows = this.blocks.get(block);
    if (rows) return rows[place % BLOCK] ?? null;
    this.wanted = block;
    if (!this.fetching) this.fetch();
    return null;
  }

  // Returns a row that is there, or undefined.
  rowOf(place) {
    if (this.order) return this.order.rows[place];
    return this.blocks.get(Math.floor(place / BLOCK))?.[place % BLOCK];
  }

  async fetch() {
    this.fetching = true;
    const viewer = await this.viewer;
    while (this.wanted !== null) {
      const block = this.wanted, { filter, blocks } = this;
      this.wanted = null;
      try {
        const { rows } = await viewer.call("rows", [filter, block * BLOCK, BLOCK]);
        blocks.set(block, rows);
      } catch {
        break;
      }
      if (blocks === this.blocks) this.tell("rows");
    }
    this.fetching = false;
  }

  // Returns the number of the packet at a place under the filter; 0 if there is none.
  async numberAt(place) {
    if (place < 0 || place >= this.matched) return 0;
    if (this.order) return this.order.rows[place]?.number ?? 0;
    if (!this.filter) return place + 1;
    const kept = this.blocks.get(Math.floor(place / BLOCK))?.[place % BLOCK];
    if (kept) return kept.number;
    const { rows } = await (await this.viewer).call("rows", [this.filter, place, 1]);
    return rows[0]?.number ?? 0;
  }

  // Returns the place of a packet under the filter, or that of the first after it; in a sorted list -1 if it is not there.
  async placeOf(number) {
    if (this.order) return this.order.places.get(number) ?? -1;
    if (!this.filter) return number - 1;
    let low = 0, high = this.matched;
    while (low < high) {
      const middle = Math.floor((low + high) / 2);
      if ((await this.numberAt(middle)) < number) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  async select(number) {
    this.number = number;
    this.packet = number ? await (await this.viewer).call("packet", [number]) : null;
    if (number === this.number) this.tell("selected");
  }

  // Goes to a packet, also to one that the filter hides: then without the filter.
  async goTo(number) {
    if (this.filter && (await this.numberAt(await this.placeOf(number))) !== number) await this.setFilter("");
    await this.select(number);
  }

  // Returns a second Wireshark with this capture, for figures. To cancel what it does ends it.
  async counting({ signal, progress }) {
    this.counter ??= startWireshark();
    const peer = await this.counter;
    peer.onbroken = () => (this.counter = this.counted = null);
    signal.addEventListener("abort", () => {
      peer.end();
      peer.onbroken();
    });
    this.counted ??= (async () => {
      await peer.call("prefer", [{ ...USUAL, ...this.preferences, ...forFigures }]);
      await peer.call("open", [this.bytes], { progress });
    })();
    await this.counted;
    return peer;
  }

  // Returns {statistics, experts}, counted once.
  figures() {
    const work = async (options) => {
      const peer = await this.counting(options);
      return peer.call("figures", [], { progress: options.progress });
    };
    this.figuresFound ??= this.long("Counting", work).catch((error) => {
      this.figuresFound = null;
      throw error;
    });
    return this.figuresFound;
  }

  async graph(wanted) {
    return this.long("Drawing", async (options) => {
      const peer = await this.counting(options);
      return peer.call("graph", [wanted], { progress: options.progress });
    });
  }
}
