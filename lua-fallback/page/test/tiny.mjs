// SPDX-License-Identifier: GPL-2.0-or-later
// Says how many lines the page writes for its Wireshark of 60 MB with packets of 4 bytes, which two interfaces take turns to
// hear. A test runs it with little memory.

import { Dissector } from "../src/dissect/dissector.js";

const PACKETS = 3_000_000;
const SECTION = [0x0a0d0d0a, 28, 0x1a2b3c4d, 1, -1, -1, 28];
const [first, second] = [0, 1].map((number) => [2, 20, number, 0, 20]); // blocks of a kind that is no longer written

const words = new Uint32Array(SECTION.length + 5 * PACKETS);
words.set(SECTION);
for (let packet = 0; packet < PACKETS; packet++) words.set(packet % 2 ? second : first, SECTION.length + 5 * packet);

let lines = 0;
const dissector = new Dissector();
dissector.library = { FS: { open: () => 1, close: () => {}, write: (file, bytes) => (lines += bytes.filter((byte) => byte === 10).length) } };
dissector.tellPlaces(new Uint8Array(words.buffer));
process.stdout.write(String(lines));
