// SPDX-License-Identifier: GPL-2.0-or-later
// What the page does with hostile input, in parts that need no Wireshark. Prints JSON.

import { isManifold } from "../src/dissect/pcapng.js";
import { fileName, visible } from "../src/front/files.js";
import { asCsv, fromCsv } from "../src/front/csv.js";
import { Peer, serve } from "../src/protocol.js";
import { Sistap } from "../src/tap/sistap.js";

const blocks = (...numbers) => new Uint8Array(Uint32Array.from(numbers.flat()).buffer);
const SECTION = [0x0a0d0d0a, 28, 0x1a2b3c4d, 1, -1, -1, 28], ARCNET = [1, 20, 7, 0, 20];

// Returns what comes of blocks of packets that are too short for their heads.
function cutPackets() {
  return [12, 16, 20, 24, 28].map((size) => {
    const block = [6, size, ...Array(size / 4 - 2).fill(0)];
    return isManifold(blocks(SECTION, ARCNET, block));
  });
}

// A sistap whose Wireshark breaks down.
function brokenSistap(text) {
  const run = () => { throw new Error(`Traceback (most recent call last):\n  File "<exec>", line 9, in run\n${text}\n`); };
  const FS = { readdir: () => [] }, globals = { get: () => Object.assign(run, { destroy() {} }) };
  return Object.assign(new Sistap(), { python: { FS, globals } });
}

// A worker in this process. Its calls are those of a Wireshark or a sistap that breaks down, or that only refuses.
function brokenPeer(open) {
  const worker = { terminate: () => (worker.isTerminated = true), postMessage: (data) => port.onmessage({ data }) };
  const port = { postMessage: (data) => queueMicrotask(() => worker.onmessage({ data })) };
  const peer = new Peer(worker);
  serve({ open, rows: () => new Promise(() => {}) }, () => 0, port);
  return { peer, worker };
}

const throwing = (error) => () => { throw error; };

async function afterwards(open) {
  const { peer, worker } = brokenPeer(open);
  let told = 0;
  peer.onbroken = () => told++;
  const failing = (name) => peer.call(name).then(() => "answered", (trouble) => trouble.message);
  const waiting = failing("rows");
  const said = await failing("open");
  const later = worker.isTerminated ? [await waiting, await failing("open")] : [];
  return { said, later, told };
}

process.stdout.write(JSON.stringify({
  cut: cutPackets(),
  names: [".log.pcapng", ".changes.csv", "-w.txt", "../../x", "..", "<img src=x>.log", ""].map(fileName),
  shown: ["a\u202eb\n\u001b\ufeff\u{e0001}\u00a0c", "Presse läuft 3.pcapng"].map(visible),
  long: fromCsv(`a,"${"x".repeat(10_000_000)}"\r\n`)[0][1].length,
  read: fromCsv(asCsv([JSON.parse(process.argv[2]), ['say "no"', "a,b", "two\r\nlines", "x"]])),
  csv: asCsv([JSON.parse(process.argv[2])]),
  broken: await afterwards(throwing(new WebAssembly.RuntimeError("Aborted(OOM)"))),
  stack: await afterwards(throwing(new RangeError("Maximum call stack size exceeded"))),
  sistap: await afterwards(() => brokenSistap("pyodide.ffi.JsException: RuntimeError: Aborted(OOM)").command()),
  memory: await afterwards(() => brokenSistap("MemoryError").command()),
  refused: await afterwards(throwing(new RangeError("Array buffer allocation failed"))),
}));
