// SPDX-License-Identifier: GPL-2.0-or-later
// sistap in a worker, started when it is needed first. To cancel what it does ends it.

import { Peer, Stopped } from "../protocol.js";
import { compiledWireshark, wiresharkFiles } from "./engine.js";
import { buffers } from "../unpack.js";
import { part, scriptAddress } from "./parts.js";

let started = null; // a promise of the peer

async function start() {
  const peer = new Peer(new Worker(await scriptAddress("tap.js")));
  const names = ["python.wasm", "python.zip", "sistap.json", "wireshark.data"];
  const [code, texts, ...parts] = await Promise.all([compiledWireshark(), wiresharkFiles(), ...names.map(part)]);
  const [pythonCode, pythonLibrary, files, data] = parts;
  peer.onbroken = () => (started = null);
  await peer.call("start", [{ pythonCode, pythonLibrary, files, wireshark: { code, data, files: texts } }], { transfer: buffers(...parts) });
  return peer;
}

export async function tap() {
  started ??= start();
  try {
    return await started;
  } catch (error) {
    started = null;
    throw error;
  }
}

let yielding = null; // a call that gives way to any other

/** Calls sistap; `signal` ends it, and then the promise fails. A call that gives way ends when the next one comes.
 * @param {string} name
 * @param {any[]} args
 * @param {{signal?: AbortSignal, progress?: (part: number) => void, givesWay?: boolean}} options
 * @returns {Promise<any>} */
export async function callTap(name, args, { signal, progress, givesWay = false } = {}) {
  yielding?.abort();
  yielding = null;
  if (!givesWay) return callNow(name, args, signal, progress);
  const mine = new AbortController();
  yielding = mine;
  return callNow(name, args, mine.signal, progress).finally(() => {
    if (yielding === mine) yielding = null;
  });
}

async function callNow(name, args, signal, progress) {
  const peer = await tap();
  const stop = () => {
    peer.end();
    peer.onbroken();
  };
  if (signal?.aborted) throw new Stopped();
  signal?.addEventListener("abort", stop);
  try {
    return await peer.call(name, args, { progress });
  } finally {
    signal?.removeEventListener("abort", stop);
  }
}
