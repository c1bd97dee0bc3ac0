// SPDX-License-Identifier: GPL-2.0-or-later
// How late this page sees what happens: a worker tells the time, and the page compares.

const TICK_MS = 4;
const KEPT_MS = 10_000; // how long a late tick counts
const SAFETY = 2; // the next one may be later than those that were seen
const LEAST_MS = 1;

export const nowMs = () => performance.timeOrigin + performance.now();

const METRONOME = `setInterval(() => postMessage(performance.timeOrigin + performance.now()), ${TICK_MS});`;

export class Lateness {
  constructor() {
    this.late = []; // [time, ms]: those that no later tick exceeds
    this.awakeMs = nowMs(); // when the page last saw a tick
    this.worker = new Worker(URL.createObjectURL(new Blob([METRONOME], { type: "text/javascript" })));
    this.worker.onmessage = ({ data }) => this.take(data);
  }

  take(sentMs) {
    const now = nowMs(), late = now - sentMs;
    while (this.late.length && this.late.at(-1)[1] <= late) this.late.pop();
    this.late.push([now, late]);
    while (this.late[0][0] < now - KEPT_MS) this.late.shift();
    this.awakeMs = now;
  }

  // The bound of how late an event is seen, from the worst tick of the last seconds.
  get boundMs() {
    return Math.max(LEAST_MS, SAFETY * (this.late[0]?.[1] ?? 0));
  }

  // For how long nobody had looked, when something is seen at a time.
  unseenMs(atMs) {
    return Math.max(0, atMs - this.awakeMs);
  }

  end() {
    this.worker.terminate();
  }
}
