// SPDX-License-Identifier: GPL-2.0-or-later
// Where there is nothing to see: says what a file is, and what to do. All such texts of the page are here.

import { Stopped } from "../protocol.js";
import { plural } from "./dom.js";
import { PROTOCOLS } from "./items.js";

const OURS = ["sertap", "rk512i", ...PROTOCOLS].join(" || ");
const OF_FIELDS = 3; // the columns from here on show fields of these protocols
const FEW = 64; // packets that are looked at first
const BLANKS = [9, 10, 13, 32];

const FILES = [
  [(bytes) => bytes.length === 0, () => "is empty. Copy it again from the computer that made it. If it is empty there, too, record again: the disk may have been full"],
  [(bytes) => bytes.every((byte) => byte === 0), ({ length }) => `has ${plural(length, "byte")}, and each is 0: it was not written or not copied to its end. Copy it again from the computer that made it`],
  [(bytes) => bytes.every((byte) => BLANKS.includes(byte)), () => "has nothing but blanks and empty lines. Save the log again, with bytes in hexadecimal"],
];

// Throws what is to be said of a file that has nothing in it.
export function refuseNothing(name, bytes) {
  const found = FILES.find(([isSo]) => isSo(bytes));
  if (found) throw new Error(`${name} ${found[1](bytes)}.`);
}

const ofNoPackets = (name) => `${name} is a capture without packets: nothing came while it was recorded. Look whether the adapter is connected \
to the line, and record again.`;

const ofNoSis = ({ name, packets }) => `${name} has ${plural(packets, "packet")}, but no SIS. If you know a TCP connection that carries SIS, open the \
file in Wireshark: Analyze > Decode As > SIS. If not, open a capture of the line to the drives.`;

// Says of the capture that is open that it has no packets, or none of a protocol of ours.
export async function noteNothing(capture) {
  if (!capture.packets) capture.note(ofNoPackets(capture.name));
  else if (!(await hasOurs(capture))) capture.note(ofNoSis(capture));
}

// Cancelled: nobody knows.
async function hasOurs(capture) {
  const { rows } = await (await capture.viewer).call("rows", ["", 0, FEW]);
  if (rows.some(({ cells }) => cells.slice(OF_FIELDS).some(Boolean))) return true;
  try {
    return (await capture.ask("Looking for SIS", "rows", [OURS, 0, 1], capture)).matched > 0;
  } catch (error) {
    if (error instanceof Stopped) return true;
    throw error;
  }
}
