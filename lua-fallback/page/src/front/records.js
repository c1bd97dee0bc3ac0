// SPDX-License-Identifier: GPL-2.0-or-later
// What lanes.lua has noted of all packets, by time, and the lane of each station.

import { kindOf } from "./rule.js";

const SIZE = 22; // bytes of a record: RECORD of lanes.lua
const NOBODY = 0xffff;

const AGAIN = "SIS: unanswered or repeated";
export const OTHER = 1, REACTION = 2, COMMAND = 3, FAULT = 4; // a column of the picture shows the greatest

export class Records {
  /** @type {Uint32Array} */ numbers; // of the packets
  /** @type {Uint32Array} */ talkers;
  /** @type {Uint32Array} */ listeners;
  /** @type {Uint32Array} */ bits; // what the rules say

  // `rules` are those of the profile, `noted` is what lanes.lua has written.
  constructor(rules, noted) {
    this.rules = rules.map((rule) => ({ words: rule.name.replace(/^.*: /, ""), kind: kindOf(rule), isAgain: rule.name === AGAIN }));
    this.unanswered = 1 << rules.length;
    const masks = this.rules.map(({ kind }, place) => [kind, 1 << place]);
    const mask = (wanted) => masks.filter(([kind]) => kind === wanted).reduce((sum, [, bit]) => sum | bit, 0);
    this.masks = { command: mask("command"), reaction: mask("reaction"), event: mask("event"), fault: mask("fault"),
      again: 1 << rules.findIndex(({ name }) => name === AGAIN) };
    this.read(noted);
    this.lanes = this.lanesOf();
    this.all = Uint32Array.from({ length: this.numbers.length }, (_, place) => place);
    this.faults = this.levels.reduce((sum, level) => sum + Number(level === FAULT), 0);
    this.silences = this.lanes.reduce((sum, { silences }) => sum + silences.length, 0);
  }

  // Takes the records apart, sorted by time: a clock may be set back.
  read(bytes) {
    const data = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    const { length } = (this.times = new Float64Array(Math.floor(bytes.length / SIZE)));
    const order = Uint32Array.from({ length }, (_, place) => place);
    const time = (place) => data.getFloat64(place * SIZE, true);
    if (order.some((place) => place > 0 && time(place) < time(place - 1))) order.sort((one, other) => time(one) - time(other));
    this.numbers = new Uint32Array(length);
    this.talkers = new Uint32Array(length);
    this.listeners = new Uint32Array(length);
    this.bits = new Uint32Array(length);
    this.lasts = new Float32Array(length);
    this.levels = new Uint8Array(length);
    this.longest = 0;
    for (let place = 0; place < length; place++) this.take(place, data, order[place] * SIZE);
    this.first = this.times[0] ?? 0;
    this.last = Math.max((this.times[length - 1] ?? 0) + (this.lasts[length - 1] ?? 0), this.first + 1e-3);
  }

  take(place, data, at) {
    const bits = data.getUint16(at + 20, true);
    this.times[place] = data.getFloat64(at, true);
    this.lasts[place] = bits & this.masks.event ? 0 : data.getFloat32(at + 8, true);
    this.numbers[place] = data.getUint32(at + 12, true);
    this.talkers[place] = data.getUint16(at + 16, true);
    this.listeners[place] = data.getUint16(at + 18, true);
    this.bits[place] = bits;
    this.levels[place] = this.levelOf(bits);
    this.longest = Math.max(this.longest, this.lasts[place]);
  }

  // A command that nobody answers is no fault of its talker.
  levelOf(bits) {
    const { command, reaction, fault, again } = this.masks;
    if (bits & fault & (bits & this.unanswered ? ~again : ~0)) return FAULT;
    if (bits & command) return COMMAND;
    return bits & reaction ? REACTION : OTHER;
  }

  // Lanes: {station, name, rank, faults, places, silences}; places of records, and of commands to it without an answer.
  lanesOf() {
    const lanes = new Map();
    const lane = (station) => {
      if (!lanes.has(station)) lanes.set(station, { station, faults: 0, places: [], silences: [] });
      return lanes.get(station);
    };
    this.numbers.forEach((_, place) => {
      const own = lane(this.talkers[place]);
      own.places.push(place);
      if (this.levels[place] === FAULT) own.faults++;
      if (this.bits[place] & this.unanswered) lane(this.listeners[place]).silences.push(place);
    });
    for (const one of lanes.values()) Object.assign(one, this.named(one));
    return [...lanes.values()].sort((one, other) => one.rank - other.rank || one.station - other.station);
  }

  // A master is who commands more than it answers.
  named({ station, places }) {
    if (station === NOBODY) return { name: "Other", rank: 2 };
    const { command, reaction } = this.masks;
    const commands = places.reduce((sum, place) => sum + Math.sign(this.bits[place] & command) - Math.sign(this.bits[place] & reaction), 0);
    return commands > 0 ? { name: `Master ${station}`, rank: 0 } : { name: `Station ${station}`, rank: 1 };
  }

  // Returns the place, in a list of places by time, of the first record that is not before a time.
  after(places, time) {
    let low = 0, high = places.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.times[places[middle]] < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  // Returns the record of a list that is nearest to a time, if it is not farther than `most`; of several, a fault.
  nearest(places, time, most) {
    let found = -1, best = Infinity;
    for (let at = this.after(places, time - most - this.longest); at < places.length && this.times[places[at]] <= time + most; at++) {
      const place = places[at], begin = this.times[place], end = begin + this.lasts[place];
      const gap = Math.max(begin - time, time - end, 0);
      const isBetter = gap < best || (gap === best && this.levels[place] > this.levels[found]);
      if (gap > most || !isBetter) continue;
      found = place;
      best = gap;
    }
    return found;
  }

  placeOf(number) {
    return this.numbers.indexOf(number);
  }

  // What a telegram is, such as "16 -> 3, command, error status".
  words(place) {
    const { talkers, listeners, bits } = this;
    const between = talkers[place] === NOBODY ? [] : [`${talkers[place]} -> ${listeners[place] === NOBODY ? "?" : listeners[place]}`];
    const said = this.rules.filter(({ isAgain }, bit) => bits[place] & (1 << bit) && !(isAgain && bits[place] & this.unanswered)).map(({ words }) => words);
    return [...between, ...said, ...(bits[place] & this.unanswered ? ["no reaction"] : [])].join(", ");
  }
}
