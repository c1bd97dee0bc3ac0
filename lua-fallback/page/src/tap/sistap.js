// SPDX-License-Identifier: GPL-2.0-or-later
// sistap in Python for WebAssembly (Pyodide). Runs in a worker and in node.

import { LARGEST } from "../dissect/dissector.js";
import { indexed } from "./loglines.js";
import { Tables } from "./rows.js";

const CAPTURE = ".log.pcapng", PAGE = ".report.html", FIGURES = ".report.json";
const LIBRARY = "/lib/sistap", WORK = "/work";
// Pyodide's list of packages: none are needed.
const NO_PACKAGES = {
  info: { abi_version: "2026_0", arch: "wasm32", platform: "emscripten_5_0_3", python: "3.14.2", version: "314.0.7" },
  packages: {},
};

const BEGIN = `
import json, os, sys
sys.path.insert(0, "${LIBRARY}")
os.chdir("${WORK}")

def run(words):
    from sistap.cli import main
    try:
        return main(words.to_py())
    except SystemExit as end:
        return end.code or 0
`;

// A file of Wireshark's folder, for the Wireshark of sistap: what it reads of USB is characters of a line, not what FTDI's
// or CDC's dissector makes of them. The command disables both (imports/usb_transfers.py) for each run.
export const OWN_FILES = { disabled_protos: "ftdi-ft\nusbcom\n" };

export class Sistap {
  // `files` are the files of sistap: {path: text}, with rows.lua among them.
  static async start(loadPyodide, { "rows.lua": script, ...files }, options) {
    const sistap = new Sistap();
    const python = await loadPyodide({ lockFileContents: NO_PACKAGES, ...options });
    sistap.python = python;
    sistap.tables = new Tables(sistap, script);
    for (const [path, text] of Object.entries(files)) {
      const whole = `${LIBRARY}/${path}`;
      python.FS.mkdirTree(whole.slice(0, whole.lastIndexOf("/")));
      python.FS.writeFile(whole, text);
    }
    python.FS.mkdirTree(WORK);
    python.registerJsModule("wireshark_of_page", sistap.tables);
    python.setStderr({ write: (bytes) => sistap.hear(bytes) });
    python.setStdout({ write: (bytes) => sistap.hear(bytes) });
    python.runPython(BEGIN);
    return sistap;
  }

  /** @type {import("../dissect/dissector.js").Dissector | null} */ wireshark = null;
  /** @type {any} */ python; // Pyodide's module
  /** @type {Tables} */ tables;
  /** @type {any} */ live; // of Python: what plays or listens
  /** @type {import("../dissect/dissector.js").Watched} */ task;
  said = "";

  // Lets a Wireshark go that holds more memory than the next capture leaves it.
  rest() {
    if (this.wireshark?.memory > LARGEST) this.tables.leave();
  }

  get memory() {
    return Math.max(this.wireshark?.memory ?? 0, this.python._module.HEAPU8.length);
  }

  hear(bytes) {
    this.said += new TextDecoder().decode(bytes);
    return bytes.length;
  }

  // Runs a command, such as ["report", "a.pcapng", "-o", "out.html"], with some files: {name: bytes}. Returns its exit
  // code, what it said, and those `wanted` files that it has written.
  command(task, words, files = {}, wanted = []) {
    const { FS } = this.python;
    for (const [name, bytes] of Object.entries(files)) FS.writeFile(`${WORK}/${name}`, bytes);
    this.task = task;
    this.said = "";
    const run = this.python.globals.get("run");
    try {
      const code = run(words);
      const there = wanted.filter((name) => FS.analyzePath(`${WORK}/${name}`).exists);
      return { code, said: this.said, written: Object.fromEntries(there.map((name) => [name, FS.readFile(`${WORK}/${name}`)])) };
    } catch (error) {
      throw new Error(said(error));
    } finally {
      run.destroy();
      this.tidy();
    }
  }

  // What `sistap report` says of a capture: {page, figures}, bytes of HTML and of JSON. `words` are options of the command.
  judge(task, name, bytes, words = []) {
    const { FS } = this.python;
    FS.writeFile(`${WORK}/${name}`, bytes);
    this.task = task;
    try {
      this.using("sistap.commands.web.judging", (judging) => judging.judge([name, ...words], PAGE, FIGURES));
      return { page: FS.readFile(`${WORK}/${PAGE}`), figures: FS.readFile(`${WORK}/${FIGURES}`) };
    } finally {
      this.tidy();
    }
  }

  // Makes a capture of a log: {capture, lines, said, unread}; `lines` are for IndexedLines. See
  // sistap/commands/web/opening.py. Null for what has to be imported.
  log(task, name, bytes, pattern = "", isPasted = false) {
    const { FS } = this.python;
    FS.writeFile(`${WORK}/${name}`, bytes);
    try {
      return this.using("sistap.commands.web.opening", (opening) => {
        if (!pattern && opening.is_import(name)) return null;
        const log = JSON.parse(opening.open_log.callKwargs(name, CAPTURE, pattern, (part) => task.progress(part), { is_pasted: isPasted }));
        const [capture, text, places] = ["", opening.LINES, opening.PLACES].map((end) => FS.readFile(`${WORK}/${CAPTURE}${end}`));
        return { ...log, capture, lines: indexed(text, new Uint32Array(places.buffer)) };
      });
    } finally {
      this.tidy();
    }
  }

  // The scenarios of the bus: [[name, title, whether faults can be switched], ...].
  scenarios() {
    return this.using("sistap.commands.web.play", (play) => JSON.parse(play.listed()));
  }

  // What a drive of the course answers to a command, in hexadecimal; empty if nobody does.
  answered(command) {
    return this.using("sistap.commands.web.play", (play) => play.answered(command));
  }

  // Begins to play a scenario, or one in a text; then `step` plays up to a time in s.
  play(name, seed, text = "") {
    if (text) this.python.FS.writeFile(`${WORK}/${name}`, text);
    try {
      this.live = this.using("sistap.commands.web.play", (play) => play.Play(name, seed));
    } finally {
      this.tidy();
    }
  }

  // Begins to listen; then `step` takes what the page has read. See sistap/commands/web/listen.py.
  listen(asked) {
    this.live = this.using("sistap.commands.web.listen", (listen) => listen.Listening(JSON.stringify(asked)));
  }

  switch(kind, isOn) {
    this.live.switch(kind, isOn);
  }

  // Goes on: with the time of the bus, or with what was read. Returns {chunk, said, isOver, wanted}.
  step(heard) {
    const chunk = bytesOf(this.live.step(typeof heard === "number" ? heard : JSON.stringify(heard)));
    const { said, is_over: isOver, wanted } = this.live;
    return { chunk, said, isOver, wanted: wanted && JSON.parse(wanted) };
  }

  // The last records as a capture, and how many of them it no longer has.
  window() {
    return { bytes: bytesOf(this.live.window()), leftOut: this.live.left_out };
  }

  // Ends it; returns the last bytes of the capture.
  end() {
    const chunk = bytesOf(this.live.end());
    this.live.destroy();
    this.live = null;
    return chunk;
  }

  using(name, work) {
    const module = this.python.pyimport(name);
    try {
      return work(module);
    } catch (error) {
      throw new Error(said(error));
    } finally {
      module.destroy();
    }
  }

  tidy() {
    const { FS } = this.python;
    for (const name of FS.readdir(WORK)) if (![".", ".."].includes(name)) FS.unlink(`${WORK}/${name}`);
  }
}

// Bytes of Python as bytes of JavaScript.
function bytesOf(proxy) {
  const bytes = proxy.toJs();
  proxy.destroy();
  return bytes;
}

// The last line of an error of Python, without the name of its class.
const said = (error) => String(error.message ?? error).trim().split("\n").at(-1).replace(/^[\w.]+: /, "");
