// SPDX-License-Identifier: GPL-2.0-or-later
// Rows of fields for sistap, as `tshark -T fields` prints them: the module wireshark_of_page of wiregasm.py.

import { USUAL } from "../dissect/dissector.js";
import { isFatal } from "../protocol.js";

const TOGETHER = 500; // packets of a piece
const READING = 0.2; // which part of the time a capture is read, before it has rows
const INFO = "_ws.col.info"; // the text in the packet list, as Wireshark calls it from 4.2 on
const TREE = "frame.number"; // a column of a field: without one there is no tree
const escaped = (text) => text.replaceAll("\\", "\\\\").replaceAll("\n", "\\n").replaceAll("\t", "\\t");

const part = (task, from, to) => ({ progress: (done) => task.progress(from + done * (to - from)) });

export class Tables {
  // `owner` has `wireshark`, a Dissector, and `task`, whose progress is told. `script` is the text of rows.lua.
  constructor(owner, script) {
    this.owner = owner;
    this.script = script;
    this.asked = "";
    this.others = []; // fields that only a column can show
  }

  // The owner's next Wireshark is a new one.
  leave() {
    this.owner.wireshark = null;
    this.asked = "";
  }

  // Returns those of some names, a list as JSON, that Wireshark does not know; undefined if there are none.
  unknown(names) {
    const found = JSON.parse(names).filter((name) => name !== INFO && this.owner.wireshark.trouble(name) !== "");
    return found.length ? found : undefined;
  }

  // Opens a capture, bytes of Python; `asked` is an Asked of wiregasm.py as JSON. `next` returns lines, and "" at the end.
  open(capture, asked) {
    const { names, joint, filter, preferences, most } = JSON.parse(asked);
    const { task } = this.owner;
    const bytes = capture.toJs();
    capture.destroy();
    const rows = { unknown: this.unknown(JSON.stringify(names)), isCapture: true, isCut: false };
    if (rows.unknown) return rows;
    this.prepare(names, joint, preferences);
    try {
      rows.isCut = this.owner.wireshark.open(part(task, 0, READING), bytes).trouble !== "";
    } catch (error) {
      if (isFatal(error)) throw error;
      rows.isCapture = false;
    }
    let skip = 0;
    rows.next = () => {
      const limit = most ? Math.min(most - skip, TOGETHER) : TOGETHER;
      const lines = limit > 0 ? this.piece(part(task, READING, 1), names, filter, skip, limit) : [];
      skip += lines.length;
      return lines.length ? lines.join("\n") : "";
    };
    return rows;
  }

  prepare(names, joint, preferences) {
    const { wireshark: dissector } = this.owner, { FS } = dissector.library;
    const asked = [joint, ...names.filter((name) => name !== INFO)].join("\n");
    if (asked !== this.asked) {
      FS.writeFile("/wanted", asked);
      FS.writeFile("/plugins/z_rows.lua", this.script);
      dissector.library.reloadLuaPlugins();
      this.others = FS.readFile("/others", { encoding: "utf8" }).split("\n").filter(Boolean);
      this.asked = asked;
    }
    const columns = ['"Info","%i"', ...[TREE, ...this.others].map((name) => `"${name}","%Cus:${name}:0:R"`)].join(",");
    dissector.prefer({ ...USUAL, "gui.column.format": columns, ...preferences });
  }

  piece(task, names, filter, skip, limit) {
    const { FS } = this.owner.wireshark.library;
    FS.writeFile("/rows", "");
    const { rows } = this.owner.wireshark.rows(task, filter, skip, limit, names);
    const ofFields = new Map(FS.readFile("/rows", { encoding: "utf8" }).split("\n").map((line) => {
      const [number, ...values] = line.split("\t");
      return [Number(number), values];
    }));
    return rows.map(({ number, cells: [info, , ...others] }) => {
      const values = ofFields.get(number)[Symbol.iterator]();
      const value = (name) => {
        if (name === INFO) return escaped(info);
        const other = this.others.indexOf(name);
        return other < 0 ? values.next().value : others[other];
      };
      return names.map(value).join("\t");
    });
  }
}
