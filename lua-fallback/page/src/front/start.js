// SPDX-License-Identifier: GPL-2.0-or-later
// Where a capture or a log comes from: dropped, chosen or pasted.

import { element } from "./dom.js";

export function startView({ left, openFiles, openPasted }) {
  const chooser = element("input", { type: "file", id: "chooser", className: "visually-hidden", onchange: () => {
    openFiles([...chooser.files]);
    chooser.value = "";
  } });
  const pasted = element("textarea", { id: "pasted", rows: 5, spellcheck: false, placeholder: "02 D9 00 00 00 12 10 03" });
  return element("section", { className: "start", "aria-labelledby": "start-title" },
    element("h1", { id: "start-title" }, "What happens on the SIS bus?"), left,
    element("div", { className: "drop" },
      element("p", { className: "large" }, "Drop a capture or a log here"),
      chooser,
      element("label", { htmlFor: "chooser", className: "button large" }, "Choose a file"),
      element("p", {}, "Captures of Wireshark (pcapng, pcap), logs of Docklight, HTerm and other programs, recordings of ",
        "USB (usbmon, USBPcap) and of logic analysers (PulseView, Saleae, DSView). Nothing leaves this computer.")),
    element("p", {}, "No file? ", element("a", { href: "#listen" }, "Listen at an adapter"), ", ",
      element("a", { href: "#play" }, "play a bus without a drive"), ", or ", element("a", { href: "#learn" }, "learn what is on it"), "."),
    element("form", { className: "paste", onsubmit: (event) => {
      event.preventDefault();
      openPasted(pasted.value);
    } },
      element("label", { htmlFor: "pasted" }, "Or paste telegrams in hexadecimal"),
      pasted,
      element("button", { type: "submit" }, "Decode")));
}

// Files may be dropped anywhere in the page.
export function takeDrops(openFiles) {
  let depth = 0;
  const show = (isOver) => document.body.classList.toggle("dropping", isOver);
  addEventListener("dragenter", (event) => {
    if (!event.dataTransfer?.types.includes("Files")) return;
    depth++;
    show(true);
  });
  addEventListener("dragleave", () => show(--depth > 0));
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    depth = 0;
    show(false);
    openFiles([...(event.dataTransfer?.files ?? [])]);
  });
}
