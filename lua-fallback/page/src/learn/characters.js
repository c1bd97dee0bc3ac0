// SPDX-License-Identifier: GPL-2.0-or-later
// The characters of packets, to be moved and changed. Every change is one of bytes.

import { allOf, firstOf } from "../front/items.js";
import { Editable } from "./bench.js";

const MOST_NS = 0xfffffffe, UNKNOWN = 0xffffffff; // of intervals; of an uncertainty

export class Characters {
  // `numbers` are those of the packets.
  constructor(bytes, numbers) {
    this.editable = new Editable(bytes);
    this.numbers = numbers;
  }

  // Takes what Wireshark says of the packets. The characters of each are in `lanes`, `widthNs` is how long one takes.
  read(packets) {
    this.packets = packets;
    this.lanes = packets.map(({ tree }, row) => this.lane(tree, this.numbers[row]));
    this.widthNs = this.lanes.at(-1).length ? this.width(packets.at(-1).tree, this.numbers.at(-1)) : 0;
  }

  // Of each character: {id, number of the packet, place in it, end (ns), fields}. The tree shows only those that say
  // something; plugin/docs/record.md says where each is in its record.
  lane(tree, number) {
    const get = (name) => this.editable.get(number, firstOf(tree, name));
    const begin = firstOf(tree, "sertap.version").start + get("sertap.header_length"), count = get("sertap.count");
    let end = this.editable.time(number);
    return Array.from({ length: count }, (_, place) => {
      const value = { start: begin + place, length: 1 }, flags = { start: begin + 5 * count + place, length: 1 };
      const interval = { start: begin + count + 4 * place, length: 4 };
      if (place) end += BigInt(this.editable.get(number, interval));
      return { id: `${number}.${place}`, number, place, end, fields: { value, interval, flags } };
    });
  }

  width(tree, number) {
    const get = (name) => this.editable.get(number, firstOf(tree, name));
    const halves = 2 * (1 + get("sertap.format.data_bits") + (get("sertap.format.parity") ? 1 : 0)) + get("sertap.format.stop");
    return (halves * 5e8) / get("sertap.baud");
  }

  // The value, interval or flags of a character.
  get({ number, fields }, which) {
    return this.editable.get(number, fields[which]);
  }

  flip(one, which, bits) {
    this.editable.set(one.number, one.fields[which], this.get(one, which) ^ bits);
  }

  // Moves a character, and with it those that follow.
  move(one, ns) {
    const { number, place } = one;
    const now = this.get(one, "interval"), least = place ? Math.round(this.widthNs) : 0;
    const next = Math.min(Math.max(Math.round(now + ns), least), MOST_NS);
    this.editable.set(number, one.fields.interval, next);
    this.editable.shift(place ? number + 1 : number, next - now);
  }

  // Sets a field of all the packets.
  setAll(name, value) {
    this.packets.forEach(({ tree }, row) => {
      for (const field of allOf(tree, name)) this.editable.set(this.numbers[row], field, value);
    });
  }

  // The uncertainty of a packet's times; 0 if it is not known.
  uncertaintyNs(row) {
    const ns = this.editable.get(this.numbers[row], firstOf(this.packets[row].tree, "sertap.uncertainty"));
    return ns === UNKNOWN ? 0 : ns;
  }

  // The character with the longest interval of a packet.
  longest(row) {
    const position = firstOf(this.packets[row].tree, "sis.tza.position")?.label.match(/: (\d+)/)?.[1] ?? 1;
    return this.lanes[row][position - 1];
  }
}
