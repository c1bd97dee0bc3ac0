// SPDX-License-Identifier: GPL-2.0-or-later
// Hears a bus for hours that pass in minutes: node hours.mjs TELEGRAMS HOURS OUT. The bytes of the file
// TELEGRAMS come again and again, at 19200 Bd without a pause. OUT becomes the capture. Prints {characters, hash of them,
// heaps}: bytes of memory of Python and of the page's script, after each tenth.

import { createHash } from "node:crypto";
import { closeSync, openSync, readFileSync, writeSync } from "node:fs";
import { setFlagsFromString } from "node:v8";
import { runInNewContext } from "node:vm";

import { startSistap } from "./parts.mjs";

const BAUD = 19200, BITS = 11, READ_MS = 16, STEP_MS = 208; // of reads, and of Live's steps
const TENTHS = 10;

setFlagsFromString("--expose-gc");
const collectGarbage = runInNewContext("gc");
const [telegrams, hours, out] = process.argv.slice(2);
const source = readFileSync(telegrams);
const endMs = Number(hours) * 3_600_000;
const sistap = await startSistap();
sistap.listen({ ports: [{ name: "test", vendor: 0 }], baud: String(BAUD), format: "8E1", late_ms: 1, system: "test" });

const file = openSync(out, "w"), hash = createHash("sha256"), heaps = [];
let characters = 0;

// The reads of a step, and their characters.
function heard(stepMs) {
  const chunks = [];
  for (let ms = stepMs; ms < stepMs + STEP_MS; ms += READ_MS) {
    const until = Math.floor(((ms + READ_MS) / 1000) * (BAUD / BITS));
    const data = Array.from({ length: until - characters }, (_, place) => source[(characters + place) % source.length]);
    hash.update(Uint8Array.from(data));
    characters = until;
    chunks.push({ line: 0, time_ms: 1.7e12 + ms + READ_MS, data, baud: BAUD, format: "8E1", unseen_ms: 0, late_ms: 1,
      error: false, lost: false, note: "" });
  }
  return chunks;
}

for (let ms = 0; ms < endMs; ms += STEP_MS) {
  writeSync(file, sistap.step(heard(ms)).chunk);
  if (Math.floor((ms * TENTHS) / endMs) === heaps.length) continue;
  sistap.window();
  collectGarbage();
  heaps.push([sistap.python._module.HEAPU8.length, process.memoryUsage().heapUsed]);
}
writeSync(file, sistap.end());
closeSync(file);
process.stdout.write(JSON.stringify({ characters, hash: hash.digest("hex"), heaps }));
