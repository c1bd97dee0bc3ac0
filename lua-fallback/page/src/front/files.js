// SPDX-License-Identifier: GPL-2.0-or-later
// Opens what a person has dropped, chosen or pasted: Wireshark reads captures, sistap reads logs and recordings of other
// tools and makes captures of them.

import { callTap } from "./tap.js";

// The first bytes of captures, in hexadecimal: pcapng, pcap with us and ns in both byte orders.
const CAPTURES = ["0a0d0d0a", "d4c3b2a1", "a1b2c3d4", "4d3cb2a1", "a1b23c4d"];
const PACKED = "1f8b"; // gzip: Wireshark unpacks it
const PASTED = "pasted telegrams";
const FIRST = 2; // packet 1 of a log is an event
const IMPORTED = ".imported.pcapng";

const head = (bytes) => Array.from(bytes.subarray(0, 4), (byte) => byte.toString(16).padStart(2, "0")).join("");

const isCapture = (bytes) => CAPTURES.includes(head(bytes)) || head(bytes).startsWith(PACKED);

export async function openBytes(capture, name, bytes, { pattern = "" } = {}) {
  const { made, log } = await captureOf(capture, name, bytes, pattern);
  await capture.open(name, made, log && { log, number: FIRST });
  if (made === bytes && /^USB/.test(capture.link)) await capture.open(name, await imported(capture, name, bytes, []));
}

// Makes a capture of a file, unless it is one: {made, log}; `log` has the lines of a log.
export async function captureOf(capture, name, bytes, pattern = "") {
  if (isCapture(bytes)) return { made: bytes };
  let log;
  try {
    log = await capture.long(`Reading ${name}`, (options) => callTap("log", [fileName(name), bytes, pattern], options));
  } catch (error) {
    throw Object.assign(error, /has no bytes|regular expression|no group/.test(error.message) ? { log: { name, bytes } } : {});
  }
  if (!log) return { made: await imported(capture, name, bytes, []) };
  const { capture: made, ...lines } = log;
  return { made, log: { ...lines, bytes, pattern } };
}

export async function openPasted(capture, text) {
  if (!text.trim()) throw new Error("Paste a telegram first");
  return openBytes(capture, PASTED, new TextEncoder().encode(text));
}

// `words` are options of `sistap import`, such as ["--baud", "9600"].
export const importBytes = async (capture, name, bytes, words) => capture.open(name, await imported(capture, name, bytes, words));

async function imported(capture, name, bytes, words) {
  const file = fileName(name);
  const { code, said, written } = await capture.long(`Importing ${name}`, (options) =>
    callTap("command", [["import", file, "-w", IMPORTED, ...words], { [file]: bytes }, [IMPORTED]], options));
  if (code) throw Object.assign(new Error(said.trim()), { import: { name, bytes } });
  return written[IMPORTED];
}

// A name that is safe in a folder of its own, beside options and beside what is written there: that begins with a point.
export const fileName = (name) => name.replace(/[^\w .-]/g, "_").replace(/^[-.]+/, "_") || "file";

// A name as sistap shows it: escapes for what nobody sees, and for what turns the direction of the words after it.
export const visible = (name) => name.replace(/[\p{C}\p{Zl}\p{Zp}]|(?! )\p{Zs}/gu, (one) => `\\u${one.codePointAt(0).toString(16).padStart(4, "0")}`);
