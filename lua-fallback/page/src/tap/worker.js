// SPDX-License-Identifier: GPL-2.0-or-later
// The worker that runs sistap. It has a Wireshark of its own, started when a command needs one; wiregasm's own script
// stands before this one.

import "./alone.js";
import createPyodideModule from "pyodide/pyodide.asm.mjs";
import { loadPyodide } from "pyodide";

import { startDissector } from "../dissect/start.js";
import { Moved, serve } from "../protocol.js";
import { text, unpacked } from "../unpack.js";
import { OWN_FILES, Sistap } from "./sistap.js";

const NOWHERE = "https://python.invalid/"; // nothing is fetched there: see below

// Calls of Sistap that need no task.
const PLAIN = ["scenarios", "answered", "play", "listen", "switch", "step", "window", "end"];

let sistap, startWireshark;

async function withWireshark(name, args) {
  sistap.wireshark ??= await startWireshark();
  try {
    return sistap[name](...args);
  } finally {
    sistap.rest();
  }
}

serve({
  async start(task, { pythonCode, pythonLibrary, files, wireshark }) {
    startWireshark = () => startDissector(self.loadWiregasm, { ...wireshark, files: { ...wireshark.files, ...OWN_FILES } });
    const [code, library] = await Promise.all([unpacked(pythonCode), unpacked(pythonLibrary)]);
    // Pyodide fetches two files, which are here already.
    const { fetch } = self;
    self.fetch = async (address, ...options) => {
      if (!String(address).startsWith(NOWHERE)) return fetch(address, ...options); // a part of the folder
      const isCode = String(address).endsWith(".wasm");
      return new Response(isCode ? code : library, { headers: { "Content-Type": isCode ? "application/wasm" : "application/zip" } });
    };
    sistap = await Sistap.start(loadPyodide, JSON.parse(await text(files)), {
      indexURL: NOWHERE, packageBaseUrl: NOWHERE, createPyodideModule,
    });
  },
  log(task, ...args) {
    const log = sistap.log(task, ...args);
    return log && new Moved(log, [log.capture, ...Object.values(log.lines)].map(({ buffer }) => buffer));
  },
  // Runs a command of sistap on files: returns {code, said, written}, those files that it has written.
  async command(...args) {
    const result = await withWireshark("command", args);
    return new Moved(result, Object.values(result.written).map(({ buffer }) => buffer));
  },
  async judge(...args) {
    const { page, figures } = await withWireshark("judge", args);
    return new Moved({ page, figures }, [page.buffer, figures.buffer]);
  },
  ...Object.fromEntries(PLAIN.map((name) => [name, (task, ...args) => sistap[name](...args)])),
}, () => sistap?.memory);
