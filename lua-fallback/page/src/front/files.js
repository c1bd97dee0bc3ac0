// SPDX-License-Identifier: GPL-2.0-or-later
// Opens what a person has dropped, chosen or pasted: Wireshark reads captures, sistap reads logs and recordings of other
// tools and makes captures of them.

import { asHex } from "./items.js";
import { noteNothing, refuseNothing } from "./nothing.js";
import { IndexedLines } from "../tap/loglines.js";
import { callTap } from "./tap.js";

// The first bytes of captures, in hexadecimal: pcapng, pcap with us and ns in both byte orders.
const CAPTURES = ["0a0d0d0a", "d4c3b2a1", "a1b2c3d4", "4d3cb2a1", "a1b23c4d"];
const PACKED = "1f8b"; // gzip: Wireshark unpacks it
const PASTED = "pasted telegrams";
const LARGEST = 200e6; // bytes of a file; a capture of 48 MB with 300,000 packets takes 0.4 GB of memory, of the 2 GB that there are
const FIRST = 2; // packet 1 of a log is an event
const IMPORTED = ".imported.pcapng";
// What a person can cure here: the layout of a log, and what a recording does not say. Where the file is, nobody asks.
const ASKS_PATTERN = /has no bytes|no telegram|regular expression|no group/;
const ASKS_OPTION = /--(baud|format|samplerate|device)\b/;
const WRITTEN = / written to \.imported\.pcapng.*/;

const head = (bytes) => asHex(bytes.subarray(0, 4), "");

const isCapture = (bytes) => CAPTURES.includes(head(bytes)) || head(bytes).startsWith(PACKED);

export function refuseTooLarge({ name, size }) {
  if (size <= LARGEST) return;
  throw new Error(`${visible(name)} has ${Math.round(size / 1e6).toLocaleString("en")} MB, and this page opens up to ${LARGEST / 1e6} MB. ` +
    "Cut a capture into parts, as editcap -c 100000 does, and open one of them; or open it in Wireshark itself");
}

export async function openBytes(capture, name, bytes, { pattern = "", isPasted = false } = {}) {
  const { made, ...origin } = await captureOf(capture, name, bytes, { pattern, isPasted });
  await capture.open(name, made, { ...origin, number: origin.log ? FIRST : 0 });
  if (made !== bytes) return;
  if (/^USB/.test(capture.link) && capture.packets) await importBytes(capture, name, bytes);
  else await noteNothing(capture);
}

/** Makes a capture of a file, unless it is one; `log` has the lines of a log, `imported` what was said of another
 * recording.
 * @returns {Promise<{made: Uint8Array, log?: any, imported?: any}>} */
export async function captureOf(capture, name, bytes, { pattern = "", isPasted = false } = {}) {
  refuseNothing(name, bytes);
  if (isCapture(bytes)) return { made: bytes };
  let log;
  try {
    log = await capture.long(`Reading ${name}`, (options) => callTap("log", [fileName(name), bytes, pattern, isPasted], options));
  } catch (error) {
    throw Object.assign(error, ASKS_PATTERN.test(error.message) ? { log: { name, bytes } } : {});
  }
  if (!log) return imported(capture, name, bytes);
  const { capture: made, lines, ...rest } = log;
  return { made, log: { ...rest, lines: new IndexedLines(lines), bytes, pattern } };
}

export async function openPasted(capture, text) {
  if (!text.trim()) throw new Error("Paste a telegram first");
  return openBytes(capture, PASTED, new TextEncoder().encode(text), { isPasted: true });
}

// `told` are options of `sistap import`, such as {baud: "9600"}.
export async function importBytes(capture, name, bytes, told) {
  const { made, ...origin } = await imported(capture, name, bytes, told);
  await capture.open(name, made, origin);
}

async function imported(capture, name, bytes, told = {}) {
  const words = Object.entries(told).flatMap(([option, value]) => [`--${option}`, value]);
  const file = fileName(name);
  const { code, said, written } = await capture.long(`Importing ${name}`, (options) =>
    callTap("command", [["import", file, "-w", IMPORTED, ...words], { [file]: bytes }, [IMPORTED]], options));
  const lines = said.trim().split("\n").map((line) => line.replace(/^sistap: /, "").replace(WRITTEN, ""));
  if (code) throw Object.assign(new Error(lines.join(" ")), ASKS_OPTION.test(said) ? { import: { name, bytes, told } } : {});
  return { made: written[IMPORTED], imported: { bytes, told, said: lines } };
}

// A name that is safe in a folder of its own, beside options and beside what is written there: that begins with a point.
export const fileName = (name) => name.replace(/[^\w .-]/g, "_").replace(/^[-.]+/, "_") || "file";

// A name as sistap shows it: escapes for what nobody sees, and for what turns the direction of the words after it.
export const visible = (name) => name.replace(/[\p{C}\p{Zl}\p{Zp}]|(?! )\p{Zs}/gu, (one) => `\\u${one.codePointAt(0).toString(16).padStart(4, "0")}`);
