// SPDX-License-Identifier: GPL-2.0-or-later
// A Wireshark of its own for what is edited: a telegram, or a packet of a capture with other times. What was asked while
// it computes is left out but for the last.

import { USUAL } from "../dissect/dissector.js";
import { packets } from "../dissect/pcapng.js";
import { startWireshark } from "../front/engine.js";

const MOST = 9; // packets
const APART_US = 20_000; // from one telegram to the next
const MAGIC = 0xa1b2c3d4, UPPER_PDU = 252, NAME = 12; // of a capture (pcap); a dissector's name is a tag of the packet

let shared = null; // a promise of the peer
let turn = Promise.resolve(); // until it is free

// Does something with the Wireshark alone: `act(peer)`.
function alone(act) {
  shared ??= startWireshark();
  const mine = turn.then(async () => act(await shared));
  turn = mine.catch(() => {});
  return mine;
}

// Tells of each display filter whether a packet of a capture matches, and the cells of the last row.
export function fits(bytes, filters) {
  return alone(async (peer) => {
    await peer.call("prefer", [USUAL]);
    await peer.call("open", [bytes]);
    const { matched, rows } = await peer.call("rows", ["", 0, MOST]);
    const met = [];
    for (const filter of filters) met.push((await peer.call("rows", [filter, 0, 1])).matched > 0);
    return { met, cells: matched ? rows.at(-1).cells : [] };
  });
}

// Shows packets of a capture by their numbers: calls `show(packets)` for the newest state only.
export class Bench {
  constructor(show) {
    this.show = show;
    this.isBusy = false;
    this.next = null;
  }

  async set(bytes, numbers, preferences = {}) {
    this.next = [bytes, numbers, preferences];
    if (this.isBusy) return;
    this.isBusy = true;
    try {
      while (this.next) {
        const [wanted, places, asked] = this.next;
        this.next = null;
        this.show(await alone(async (peer) => {
          await peer.call("prefer", [{ ...USUAL, ...asked }]);
          await peer.call("open", [wanted]);
          const found = [];
          for (const place of places) found.push(await peer.call("packet", [place]));
          return found;
        }));
      }
    } finally {
      this.isBusy = false;
    }
  }
}

// A capture with telegrams of a protocol, without a tap. The length of a name is a multiple of four.
export function telegramCapture(protocol, ...telegrams) {
  const name = new TextEncoder().encode(protocol.padEnd(4 * Math.ceil((protocol.length + 1) / 4), "\0"));
  const head = words(MAGIC, 0x00020004, 0, 0, 0x40000, UPPER_PDU);
  return Uint8Array.from([...head, ...telegrams.flatMap((telegram, place) => {
    const packet = [0, NAME, 0, name.length, ...name, 0, 0, 0, 0, ...telegram];
    return [...words(0, place * APART_US, packet.length, packet.length), ...packet];
  })]);
}

const words = (...numbers) => numbers.flatMap((number) => [24, 16, 8, 0].map((shift) => (number >>> shift) & 0xff));

// A capture whose packets can be changed where Wireshark says that a field is.
export class Editable {
  constructor(bytes) {
    this.bytes = bytes.slice();
    this.data = new DataView(this.bytes.buffer);
    this.places = [...packets(this.bytes)];
  }

  get(number, field) {
    const at = this.places[number - 1].data + field.start;
    return this.data[{ 1: "getUint8", 2: "getUint16", 4: "getUint32" }[field.length]](at);
  }

  set(number, field, value) {
    const at = this.places[number - 1].data + field.start;
    if (field.length === 4) this.data.setUint32(at, value);
    else this.data.setUint8(at, value);
  }

  // The time of a packet, in ns since 1970.
  time(number) {
    const { time, little } = this.places[number - 1];
    return (BigInt(this.data.getUint32(time, little)) << 32n) + BigInt(this.data.getUint32(time + 4, little));
  }

  // Moves a packet, and all that follow it, in time.
  shift(number, ns) {
    for (let moved = number; moved <= this.places.length; moved++) {
      const { time, little } = this.places[moved - 1];
      const stamp = this.time(moved) + BigInt(Math.round(ns));
      this.data.setUint32(time, Number(stamp >> 32n), little);
      this.data.setUint32(time + 4, Number(stamp & 0xffffffffn), little);
    }
  }
}
