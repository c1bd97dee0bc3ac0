// SPDX-License-Identifier: GPL-2.0-or-later
// Calls from the page to a worker: {id, name, args} there; {id, result}, {id, error} or {id, progress} back. A worker that
// computes reads no messages, so a call is cancelled by ending the worker.

const TELL_MS = 100;

// A result with buffers that move to the page instead of being copied.
export class Moved {
  constructor(value, transfer) {
    this.value = value;
    this.transfer = transfer;
  }
}

// In the worker: calls a handler of that name, with a task first: task.progress(part) tells the page how far it is.
// `memory` returns how many bytes the program holds.
export function serve(handlers, memory, port = self) {
  port.onmessage = async ({ data: { id, name, args } }) => {
    try {
      const result = await handlers[name](new Task((progress) => port.postMessage({ id, progress })), ...args);
      const { value, transfer } = result instanceof Moved ? result : { value: result, transfer: [] };
      port.postMessage({ id, result: value }, transfer);
    } catch (error) {
      const text = String(error?.message ?? error);
      if (isFatal(error)) port.postMessage({ id, error: `${OUT.test(text) || memory() > FULL ? TOO_MUCH : DAMAGED} (${text})`, isBroken: true });
      else port.postMessage({ id, error: text });
    }
  };
  port.postMessage({ ready: true });
}

const FULL = 1.5e9; // bytes; a program of WebAssembly can have 2 GB
const OUT = /\bOOM\b|^MemoryError/;
const TOO_MUCH = "This needs more memory than a page has. Cut the capture into parts of 100,000 packets, as " +
  "editcap -c 100000 does, and open one of them; or open it in Wireshark itself";
const DAMAGED = "This file is damaged, and Wireshark in this page cannot go on with it: open it in Wireshark itself";

// Whether a program of WebAssembly cannot go on after it: a trap, abort() or exit() of C, no room for its stack or in its
// memory. What came through Python has only its text.
export const isFatal = (error) => error instanceof WebAssembly.RuntimeError || error?.name === "ExitStatus" ||
  /^(RuntimeError|ExitStatus): |^MemoryError|fatally failed|call stack|too much recursion/.test(String(error?.message ?? error));

class Task {
  constructor(tell) {
    this.tell = tell;
    this.told = performance.now();
  }

  // From 0 to 1; told at most every TELL_MS.
  progress(part) {
    const now = performance.now();
    if (now - this.told < TELL_MS) return;
    this.told = now;
    this.tell(part);
  }
}

// In the page: a worker, and the calls that it has not answered.
export class Peer {
  constructor(worker) {
    this.worker = worker;
    this.calls = new Map();
    this.number = 0;
    this.isOver = false;
    this.onbroken = () => {}; // its program cannot go on, and the worker has been ended
    this.ready = new Promise((resolve, reject) => {
      worker.onmessage = ({ data }) => (data.ready ? resolve() : this.take(data));
      worker.onerror = (event) => {
        event.preventDefault();
        const error = new Error(event.message || "A worker of this page does not start: load the page again");
        reject(error);
        this.breakDown(error);
      };
    });
    this.ready.catch(() => {});
  }

  // Returns a promise. `progress` is called with a part from 0 to 1.
  async call(name, args = [], { progress = () => {}, transfer = [] } = {}) {
    await this.ready;
    if (this.isOver) throw new Stopped(); // it would never answer
    const id = ++this.number;
    return new Promise((resolve, reject) => {
      this.calls.set(id, { resolve, reject, progress });
      this.worker.postMessage({ id, name, args }, transfer);
    });
  }

  take({ id, result, error, progress, isBroken }) {
    const call = this.calls.get(id);
    if (!call) return;
    if (progress !== undefined) {
      call.progress(progress);
    } else if (isBroken) {
      this.breakDown(new Error(error));
    } else {
      this.calls.delete(id);
      if (error !== undefined) call.reject(new Error(error));
      else call.resolve(result);
    }
  }

  breakDown(error) {
    this.end(error);
    this.onbroken();
  }

  fail(error) {
    for (const call of this.calls.values()) call.reject(error);
    this.calls.clear();
  }

  // Ends the worker; calls that it has not answered fail.
  end(error = new Stopped()) {
    this.isOver = true;
    this.worker.terminate();
    this.fail(error);
  }
}

// A person has cancelled what was done.
export class Stopped extends Error {
  constructor() {
    super("stopped");
  }
}
