// SPDX-License-Identifier: GPL-2.0-or-later
// Asks for one port, or for the two of a full-duplex tap. Nothing is ever written to a port.

import { button, element } from "./dom.js";
import { listenAtPorts } from "./hearing.js";
import { ListeningPort } from "./port.js";

const RATES = [9600, 19200, 38400, 57600, 115200];
const FORMATS = ["8E1", "8N1", "8O1", "7E1"];
const CHOOSE = ["Choose a port", "Choose a second port, for the other direction of a full-duplex line", "Choose again"]; // with so many ports
const MOST_PORTS = 2;

const WARNING = `Opening a port can switch the transmitter of an adapter on for a moment: the browser raises RTS and DTR, then this \
page lowers them. If that could disturb a machine, open the port before you connect + and -.`;

export function listenView(capture, { showing }) {
  return element("section", { className: "page", "aria-labelledby": "listen-title" },
    element("h1", { id: "listen-title" }, "Listen at a serial port"),
    ...("serial" in navigator ? [
      element("p", {}, "Connect only +, - and ground of an RS485 adapter, without its 120 ohm resistor. This page never writes to a port."),
      element("p", {}, WARNING),
      portForm(showing, (asked) => listenAtPorts(capture, asked)),
    ] : [element("p", {}, "This browser cannot read serial ports. Chrome, Edge, Opera and Firefox from version 151 on can. ",
      "Or capture with ", element("code", {}, "sistap capture"), ", and open the file here.")]));
}

// A form; `listen` gets what was chosen: {ports, rate, format, file}.
function portForm(showing, listen) {
  const ports = [];
  const chosen = element("ol", { className: "ports" });
  const rate = element("select", { id: "rate" }, element("option", { value: "auto" }, "find it"),
    ...RATES.map((baud) => element("option", { value: baud }, `${baud} Bd`)));
  const format = element("select", { id: "line-format" }, ...FORMATS.map((name) => element("option", { value: name }, name)));
  const intoFile = element("input", { type: "checkbox", id: "into-file", disabled: !("showSaveFilePicker" in globalThis) });
  const start = element("button", { type: "submit", className: "large", disabled: true }, "Listen");
  const choose = button(CHOOSE[0], () => showing(async () => {
    if (ports.length === MOST_PORTS) ports.length = 0;
    const port = await navigator.serial.requestPort();
    if (!ports.includes(port)) ports.push(port);
    chosen.replaceChildren(...ports.map((one) => element("li", {}, ListeningPort.nameOf(one))));
    choose.textContent = CHOOSE[ports.length];
    start.disabled = ports.length === 0;
  }));
  return element("form", { className: "choices-form", onsubmit: (event) => {
    event.preventDefault();
    showing(async () => listen({ ports, rate: rate.value, format: format.value, file: intoFile.checked ? await namedFile() : null }));
  } },
    element("p", {}, choose), chosen,
    element("p", { className: "field-line" }, element("label", { htmlFor: "rate" }, "Rate"), rate),
    element("p", { className: "field-line" }, element("label", { htmlFor: "line-format" }, "Format of a character, if the rate is known"), format),
    element("p", {}, intoFile, element("label", { htmlFor: "into-file" }, " Write into a file from the beginning")),
    element("p", {}, start));
}

async function namedFile() {
  const handle = await showSaveFilePicker({ suggestedName: "bus.pcapng", types: [{ accept: { "application/vnd.tcpdump.pcap": [".pcapng"] } }] });
  return handle.createWritable();
}
