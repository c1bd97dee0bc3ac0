// SPDX-License-Identifier: GPL-2.0-or-later
// Wireshark in a worker. One shows the packets; a second one, made when it is needed, counts figures of the same capture,
// so that the list stays quick.

import { Peer } from "../protocol.js";
import { buffers } from "../unpack.js";
import { part, partText, scriptAddress } from "./parts.js";

const FILES = ["page.lua", "sis.lua", "lanes.lua", "preferences", "colorfilters", "dmacros"];

let compiled = null; // a promise of Wireshark's compiled code, for the next worker
let script = null; // a promise of the address of the worker's script

export const compiledWireshark = () => compiled;

export async function wiresharkFiles() {
  const texts = await Promise.all(FILES.map(partText));
  return Object.fromEntries(FILES.map((name, place) => [name, texts[place]]));
}

// Starts Wireshark; the peer's `version` is then known.
export async function startWireshark() {
  const started = start(compiled ?? part("wireshark.wasm"));
  compiled ??= started.then(({ code }) => code, (error) => {
    compiled = null;
    throw error;
  });
  return (await started).peer;
}

async function start(wanted) {
  script ??= scriptAddress("dissect.js");
  const peer = new Peer(new Worker(await script));
  const [files, data, given] = await Promise.all([wiresharkFiles(), part("wireshark.data"), wanted]);
  const { code, version } = await peer.call("start", [{ code: given, data, files }], { transfer: buffers(given, data) });
  return { code, peer: Object.assign(peer, { version }) };
}
