// SPDX-License-Identifier: GPL-2.0-or-later
// What is heard now becomes a capture: at one port of the browser, or at the two of a full-duplex line.

import { keepAs } from "./keeping.js";
import { Lateness } from "./lateness.js";
import { Live } from "./live.js";
import { ListeningPort } from "./port.js";
import { callTap } from "./tap.js";

const MEASURE_MS = 500; // how long the page measures itself before it listens
const FOUND_FIRST = { baud: 9600, format: "8E1" }; // where the search for a rate begins
const AUTO = "auto";

// `rate` is a number, or "auto"; `file` is where the capture goes from its beginning on, or null.
export async function listenAtPorts(capture, { ports, rate, format, file }) {
  const lateness = await capture.long("Starting sistap, and measuring how late this page is", measured);
  const settings = rate === AUTO ? FOUND_FIRST : { baud: Number(rate), format };
  await callTap("listen", [{
    ports: ports.map((port) => ({ name: ListeningPort.nameOf(port), vendor: port.getInfo?.().usbVendorId ?? 0 })),
    baud: rate, format: settings.format, late_ms: lateness.boundMs, system: navigator.userAgent,
  }]);
  const heard = [];
  const lines = ports.length === 1 ? [0] : [1, 2];
  const listening = ports.map((port, place) => new ListeningPort(port, lines[place], lateness, (chunk) => heard.push(chunk)));
  for (const port of listening) await port.open(settings);
  await show(capture, {
    async next() {
      const result = await callTap("step", [heard.splice(0)]);
      const { baud, format: shape } = result.wanted;
      for (const port of listening) if (port.baud !== baud || port.format !== shape) await port.change(result.wanted);
      return result;
    },
    async close() {
      lateness.end();
      await Promise.all(listening.map((port) => port.close()));
      return heard.splice(0);
    },
  }, file);
}

async function measured(options) {
  await callTap("scenarios", [], options);
  const lateness = new Lateness();
  await new Promise((resolve) => setTimeout(resolve, MEASURE_MS));
  return lateness;
}

async function show(capture, source, file) {
  location.hash = "#packets";
  const name = `listened ${new Date().toISOString().slice(0, 19).replaceAll(":", "-")}.pcapng`;
  await new Live(capture, { title: "Listening", name, controls: [], ...source }, { kept: await keepAs(name), file }).run();
}
