// SPDX-License-Identifier: GPL-2.0-or-later
// In place of the browser's serial ports: the test feeds them. Runs before the page's scripts.

const serialTest = { ports: [], opened: [], signals: [], writes: 0 };

globalThis.serialTest = serialTest;

class TestPort extends EventTarget {
  getInfo() {
    return { usbVendorId: 0x1a86, usbProductId: 0x7523 };
  }

  async open(options) {
    serialTest.opened.push(options);
    this.isOpen = true;
    this.renew();
  }

  async close() {
    this.isOpen = false;
    this.stream = null;
  }

  async setSignals(signals) {
    serialTest.signals.push(signals);
  }

  renew() {
    this.stream = new ReadableStream({ start: (controller) => (this.controller = controller) });
  }

  get readable() {
    return this.isOpen ? this.stream : null;
  }

  get writable() {
    serialTest.writes++;
    return null;
  }

  feed(base64) {
    if (this.isOpen) this.controller.enqueue(Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0)));
  }

  fail(name) {
    const { controller } = this;
    if (name === "NetworkError") this.stream = null;
    else this.renew();
    controller.error(new DOMException("", name));
  }
}

Object.defineProperty(navigator, "serial", {
  value: {
    async requestPort() {
      serialTest.ports.push(new TestPort());
      return serialTest.ports.at(-1);
    },
  },
});
