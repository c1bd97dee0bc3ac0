// SPDX-License-Identifier: GPL-2.0-or-later
// The lines of a log, and which packets stand in them, as arrays of numbers: a log may have millions of lines, and they
// move from the worker to the page without being copied.

const NEW_LINE = 10;
const PACKET = 0, LINE = 1, BEGIN = 2, END = 3, NUMBERS = 4; // of a place

// `text` has the lines in UTF-8, `places` are those of sistap/commands/web/opening.py.
export function indexed(text, places) {
  const starts = startsOf(text);
  return { text, starts, places, ...byLine(places, starts.length - 1) };
}

function startsOf(text) {
  let count = 1;
  for (let at = text.indexOf(NEW_LINE); at >= 0; at = text.indexOf(NEW_LINE, at + 1)) count++;
  const starts = new Uint32Array(count);
  for (let line = 1, at = 0; line < count; line++) starts[line] = at = text.indexOf(NEW_LINE, at) + 1;
  return starts;
}

// The numbers of the places in the order of lines, and which of them is the first of a line.
function byLine(places, lines) {
  const count = places.length / NUMBERS, firsts = new Uint32Array(lines + 1), order = new Uint32Array(count);
  const lineOf = (place) => places[NUMBERS * place + LINE];
  for (let place = 0; place < count; place++) firsts[lineOf(place) + 1]++;
  for (let line = 0; line < lines; line++) firsts[line + 1] += firsts[line];
  const next = firsts.slice();
  for (let place = 0; place < count; place++) order[next[lineOf(place)]++] = place;
  return { firsts, order };
}

// What `indexed` has found, to be asked.
export class IndexedLines {
  constructor({ text, starts, places, firsts, order }) {
    this.text = text;
    this.starts = starts;
    this.places = places;
    this.firsts = firsts;
    this.order = order;
    this.decoder = new TextDecoder();
    this.count = starts.length - 1;
  }

  line(number) {
    return this.decoder.decode(this.text.subarray(this.starts[number], this.starts[number + 1] - 1));
  }

  // Where packets stand in a line, from left to right: [{packet, begin, end}]; packets from 0.
  marks(number) {
    const { places } = this;
    return Array.from(this.order.subarray(this.firsts[number], this.firsts[number + 1]), (place) => {
      const at = NUMBERS * place;
      return { packet: places[at + PACKET], begin: places[at + BEGIN], end: places[at + END] };
    }).sort((one, other) => one.begin - other.begin);
  }

  // The line in which a packet begins; undefined if it is not in the log.
  lineOf(packet) {
    const { places } = this;
    let low = 0, high = places.length / NUMBERS;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (places[NUMBERS * middle + PACKET] < packet) low = middle + 1;
      else high = middle;
    }
    return places[NUMBERS * low + PACKET] === packet ? places[NUMBERS * low + LINE] : undefined;
  }
}
