// SPDX-License-Identifier: GPL-2.0-or-later
// A serial port of the browser (Web Serial), read and never written. What it delivers becomes chunks for sistap.

import { nowMs } from "./lateness.js";

const BUFFER = 16_384; // bytes that the browser keeps if the page is slow
const PARITIES = { N: "none", E: "even", O: "odd" };
const LOST = ["BufferOverrunError"]; // errors after which characters are missing
const GONE = ["NetworkError"];

export class ListeningPort {
  // `hear` is called with chunks as sistap/commands/web/listen.py takes them.
  constructor(port, line, lateness, hear) {
    this.port = port;
    this.line = line;
    this.lateness = lateness;
    this.hear = hear;
    this.isEnding = false;
  }

  static nameOf(port) {
    const { usbVendorId, usbProductId } = port.getInfo?.() ?? {};
    const hex = (number) => number.toString(16).padStart(4, "0");
    return usbVendorId === undefined ? "serial port" : `USB adapter ${hex(usbVendorId)}:${hex(usbProductId)}`;
  }

  async open({ baud, format }) {
    const [dataBits, parity, stopBits] = [Number(format[0]), PARITIES[format[1]], Number(format.slice(2))];
    if (!parity || ![7, 8].includes(dataBits)) throw new Error(`A browser cannot read the format ${format}`);
    await this.port.open({ baudRate: baud, dataBits, parity, stopBits, bufferSize: BUFFER }).catch(({ message }) => {
      throw new Error(`${ListeningPort.nameOf(this.port)} cannot be opened: close the program that uses it, or plug it in again (${message})`);
    });
    // The browser raises both. On many adapters RTS switches the transmitter on.
    await this.port.setSignals({ dataTerminalReady: false, requestToSend: false }).catch(() => {});
    this.baud = baud;
    this.format = format;
    this.ended = this.readAll();
  }

  // Reads until the port is closed. An error ends `readable`, and another one follows.
  async readAll() {
    let error = "";
    while (this.port.readable && !this.isEnding) {
      this.reader = this.port.readable.getReader();
      try {
        for (;;) {
          const { value, done } = await this.reader.read();
          if (done) break;
          this.take(value, error);
          error = "";
        }
      } catch (failure) {
        if (error) this.take(new Uint8Array(), error);
        error = failure.name;
        if (GONE.includes(error)) break;
      } finally {
        this.reader.releaseLock();
      }
    }
    if (!this.isEnding) this.hear({ line: this.line, gone: `${ListeningPort.nameOf(this.port)} is gone: plug the adapter in and listen again` });
  }

  take(value, error) {
    const time = nowMs();
    this.hear({
      line: this.line, time_ms: time, data: Array.from(value), baud: this.baud, format: this.format,
      unseen_ms: this.lateness.unseenMs(time), late_ms: this.lateness.boundMs,
      error: error !== "" && !LOST.includes(error), lost: LOST.includes(error),
      note: error && !value.length ? `the browser reports ${error}, and no character with it` : "",
    });
  }

  async close() {
    this.isEnding = true;
    await this.reader?.cancel().catch(() => {});
    await this.ended;
    await this.port.close().catch(() => {});
    this.isEnding = false;
  }

  // Goes on with other settings.
  async change(settings) {
    await this.close();
    await this.open(settings);
  }
}
