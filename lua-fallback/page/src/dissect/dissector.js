// SPDX-License-Identifier: GPL-2.0-or-later
// One capture in libwireshark (wiregasm) with sis.lua: rows, packets, filters, figures. Runs in a worker and in node.

import { isManifold, places } from "./pcapng.js";

const CAPTURE = "/uploads/capture", TOLD = "/told", GENERATED = "/generated"; // page.lua reads and writes them, too
const TOGETHER = 1 << 16; // characters that are written at once
const PROFILE = "/home/web_user/.config/wireshark";
const STATISTICS = "srt,tree"; // Wireshark prints the last one first
const AFTERWARDS = ["frame.coloring_rule.name 0 0", "frame.coloring_rule.string 0 0"]; // generated after page.lua has looked
const OF_LANES = "sis.talker sis.listener sis.command.unanswered sertap.count sertap.baud";
const PORTS = "synaxpd.ports"; // of no protocol, unless a preference names them
/** @type {Watched} */ const UNWATCHED = { progress: () => {} };

// What Wireshark finds in a personal folder: the profile, and that SIS may be in captures of RTAC.
const OWN_FILES = { decode_as_entries: "decode_as_entry: rtacser.data,0,(none),SIS\n" };

// Returns the items of a vector of C++, each through a function, and frees it.
function taken(vector, of = (/** @type {any} */ item) => item) {
  const items = [];
  for (let place = 0; place < vector.size(); place++) items.push(of(vector.get(place)));
  vector.delete();
  return items;
}

const colour = (number) => `#${number.toString(16).padStart(6, "0")}`;
const UNCOLOURED = 1; // wiregasm's background of a packet that no rule colours

/** A row of the list; `paper` and `ink` are colours, or "".
 * @typedef {{number: number, cells: string[], paper: string, ink: string}} Row */
/** An item of a packet's tree: where its bytes are in a source, and the packet that a link leads to.
 * @typedef {{label: string, filter: string, start: number, length: number, source: number, severity: string, type: string,
 *   to: number, isGenerated: boolean, tree: Item[]}} Item */
/** A packet, with all bytes that it is made of.
 * @typedef {{tree: Item[], sources: {name: string, bytes: Uint8Array}[], comments: string[]}} Packet */
/** Whose progress is told, from 0 to 1.
 * @typedef {{progress: (part: number) => void}} Watched */

export class Dissector {
  /** @type {any} */ library; // wiregasm's module
  /** @type {any} */ session; // its capture, or null

  // `load` is wiregasm's loader, `files` the texts of sis.lua, page.lua and the profile, by name.
  static async start(load, files, options = {}) {
    const dissector = new Dissector();
    dissector.library = await load({
      handleStatus: () => {},
      print: (line) => dissector.printed.push(line),
      printErr: (line) => /DFilter INFO/.test(line) || dissector.complaints.push(line),
      ...options,
    });
    dissector.begin(files);
    return dissector;
  }

  constructor() {
    this.printed = [];
    this.complaints = [];
    this.session = null;
    this.hasPorts = false;
    this.task = UNWATCHED; // whose progress is told while the capture is read
  }

  begin({ "page.lua": page, "sis.lua": script, "lanes.lua": lanes, ...profile }) {
    const { FS } = this.library;
    FS.writeFile("/plugins/page.lua", page); // Wireshark loads them in this order
    FS.writeFile("/plugins/sis.lua", script);
    FS.writeFile("/plugins/z_lanes.lua", lanes);
    this.rules = String(profile.colorfilters);
    FS.mkdirTree(PROFILE);
    for (const [name, text] of Object.entries({ ...OWN_FILES, ...profile })) FS.writeFile(`${PROFILE}/${name}`, text);
    this.library.init();
  }

  // Bytes; they never get fewer.
  get memory() {
    return this.library.HEAPU8.length;
  }

  get version() {
    return this.library.wiresharkVersion();
  }

  // Sets preferences, such as {"sis.tza_ms": 8}; they count from the next capture on.
  prefer(preferences) {
    for (const [name, value] of Object.entries(preferences)) {
      const [module, ...key] = name.split(".");
      const { code, error } = this.library.setPref(module, key.join("."), String(value));
      if (code) throw new Error(`${name} = ${value}: ${error || "Wireshark does not know it"}`);
      if (name === PORTS) this.hasPorts = value !== "";
    }
    this.library.applyPreferences();
  }

  // Lets sis.lua make only the fields that some texts name, such as filters; all of them if there are no texts, or if
  // one names a macro. While a capture is open, applied preferences give ports back to Wireshark's own protocols.
  want(...texts) {
    if (this.hasPorts) return;
    const text = texts.join(" ");
    this.prefer({ "sis.fields": text.includes("$") ? "" : (text.match(/[\w.]+/g) ?? []).join() });
  }

  /** Opens a capture; returns how many packets it has, and what is wrong with it.
   * @param {Watched} task
   * @param {Uint8Array} bytes */
  open(task, bytes) {
    this.close();
    const { FS, DissectSession } = this.library;
    FS.writeFile(CAPTURE, bytes);
    if (isManifold(bytes)) this.tellPlaces(bytes);
    this.watch(FS, bytes.length);
    this.session = new DissectSession(CAPTURE);
    this.filter = ""; // the last one
    this.counted = null; // what a pass for figures has found
    const { code, error, summary } = this.during(task, () => this.session.load());
    if (error || (code && !summary.packet_count)) {
      this.close();
      throw new Error("Wireshark cannot read this file: it is no capture, or it is damaged from its beginning on. If it is a recording of another program, save it there as text");
    }
    return { packets: summary.packet_count, link: summary.file_encap_type, seconds: summary.elapsed_time,
      memory: this.memory,
      trouble: code ? "The capture is cut off or damaged: this is what comes before the damage." : "" };
  }

  // Writes for page.lua where each packet is from, in a line.
  tellPlaces(bytes) {
    const { FS } = this.library;
    const file = FS.open(TOLD, "w"), encoder = new TextEncoder();
    let lines = "";
    const write = () => {
      const packed = encoder.encode(lines);
      FS.write(file, packed, 0, packed.length);
      lines = "";
    };
    for (const { section, number, start, length } of places(bytes)) {
      lines += length ? `${section} ${number} ${start} ${length}\n` : `${section} ${number}\n`;
      if (lines.length > TOGETHER) write();
    }
    write();
    FS.close(file);
  }

  close() {
    this.session?.delete();
    this.session = null;
    const { FS } = this.library;
    for (const path of [TOLD, CAPTURE]) if (FS.analyzePath(path).exists) FS.unlink(path);
  }

  // Tells the progress when the capture is read.
  watch(FS, size) {
    const { node } = FS.lookupPath(CAPTURE);
    const { stream_ops } = node;
    node.stream_ops = {
      ...stream_ops,
      read: (stream, buffer, offset, length, position) => {
        this.task.progress(position / size);
        return stream_ops.read(stream, buffer, offset, length, position);
      },
    };
  }

  /** @param {Watched} task
   * @param {() => any} work */
  during(task, work) {
    this.task = task;
    try {
      return work();
    } finally {
      this.task = UNWATCHED;
    }
  }

  // Returns Wireshark's own words about a display filter; empty if it is valid.
  trouble(filter) {
    return this.library.checkFilter(filter).error;
  }

  // Returns fields and protocols that begin so: [{field, type, name}].
  completions(beginning) {
    return taken(this.library.completeFilter(beginning).fields);
  }

  /** Returns how many packets a filter leaves, and some rows of them. Wireshark remembers which packets pass a filter.
   * `fields` are all those of the columns, if no rows are coloured.
   * @param {Watched} task
   * @param {string} filter
   * @param {number} skip
   * @param {number} limit
   * @param {string[]} fields
   * @returns {{matched: number, rows: Row[]}} */
  rows(task, filter, skip, limit, fields = []) {
    const trouble = filter && this.trouble(filter);
    if (trouble) throw new Error(trouble);
    const framesOf = (...rows) => this.during(task, () => this.session.getFrames(filter, ...rows));
    if (filter && filter !== this.filter) {
      this.want(filter);
      framesOf(0, 1).frames.delete();
      this.filter = filter;
    }
    this.want(...fields);
    const { matched, frames } = framesOf(skip, limit);
    const rows = taken(frames, ({ number, columns, bg, fg }) =>
      ({ number, cells: taken(columns, visible), paper: bg === UNCOLOURED ? "" : colour(bg), ink: bg === UNCOLOURED ? "" : colour(fg) }));
    return { matched, rows };
  }

  /** A packet; of what Wireshark shows in brackets, isGenerated is true.
   * @param {number} number
   * @returns {Packet} */
  packet(number) {
    this.want();
    const { tree, data_sources, comments, follow } = this.session.getFrame(number);
    taken(follow, (one) => taken(one));
    const generated = new Set([...AFTERWARDS, ...this.library.FS.readFile(GENERATED, { encoding: "utf8" }).split("\n")]);
    return {
      tree: taken(tree, (item) => branch(item, generated)),
      sources: taken(data_sources, ({ name, data }) => ({ name, bytes: Uint8Array.from(atob(data), (c) => c.charCodeAt(0)) })),
      comments: taken(comments),
    };
  }

  // Returns the statistics of sis.lua and the expert items. The preferences have to be set before the capture is opened:
  // `forFigures`.
  figures(task) {
    const { statistics, experts } = this.count(task);
    return { statistics, experts: experts ? experts.split("\n").map((line) => line.split("\t")) : [] };
  }

  // Returns what lanes.lua has noted, as bytes. The preferences are those of figures; the second of both takes no time.
  lanes(task) {
    return this.count(task).lanes;
  }

  // Dissects all packets once more, for all figures.
  count(task) {
    if (this.counted) return this.counted;
    const { FS } = this.library;
    this.printed.length = 0;
    this.graph(task, { graph0: "packets", interval: "1000000" }, OF_LANES, this.rules);
    this.counted = { statistics: this.printed.join("\n"), experts: FS.readFile("/experts", { encoding: "utf8" }), lanes: FS.readFile("/lanes") };
    return this.counted;
  }

  // Runs Wireshark's I/O graphs; returns the values of each. `others` are texts with more fields to make.
  graph(task, wanted, ...others) {
    const input = new this.library.MapInput();
    for (const [name, text] of Object.entries(wanted)) input.set(name, text);
    this.want(...Object.values(wanted), ...others);
    const { error, iograph } = this.during(task, () => this.session.iograph(input));
    input.delete();
    const graphs = taken(iograph, ({ items }) => taken(items));
    if (error) throw new Error(error);
    return graphs;
  }
}

// Bytes of memory of a Wireshark that opens one capture after the other; then another one goes on.
export const LARGEST = 700_000_000;

// What a person may change, as Wireshark has it.
export const USUAL = { "sis.edition": "IF02", "sis.tza_ms": 0, "sis.trs_ms": 0 };

export const forFigures = { "sis.statistics": STATISTICS, "page.experts": "TRUE", "page_lanes.on": "TRUE" };

// Marks that turn the direction of writing, as the Wireshark of Debian 12 shows them; this one leaves them as they are.
const visible = (text) => text.replace(/[\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]/g,
  (mark) => `\\u${mark.charCodeAt(0).toString(16).toUpperCase().padStart(4, "0")}`);

function branch({ label, filter, start, length, data_source_idx, severity, type, fnum, tree }, generated) {
  const made = { label: visible(label), filter, start, length, source: data_source_idx, severity, type, to: fnum,
    tree: taken(tree, (item) => branch(item, generated)) };
  if (generated.has(`${nameOf(filter)} ${start} ${length}`)) made.isGenerated = true;
  return made;
}

const nameOf = (filter) => filter.slice(0, filter.search(/[ []|$/));
