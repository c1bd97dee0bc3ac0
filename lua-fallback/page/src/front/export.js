// SPDX-License-Identifier: GPL-2.0-or-later
// Saves what is shown: packets, their rows, their trees; long data that Wireshark has put together; the log, explained.

import { isPcapng, only } from "../dissect/pcapng.js";
import { asCsv } from "./csv.js";
import { button, element, plural, save } from "./dom.js";
import { everyRow } from "./everyrow.js";
import { textOf } from "./items.js";
import { callTap } from "./tap.js";

const WHOLE = "sis.sequence.length || synax.pieces.length"; // packets that end long data

export function exportDialog(capture, columns, { showing }) {
  const dialog = element("dialog", { "aria-labelledby": "export-title" });
  const act = (work) => () => {
    dialog.close();
    showing(work);
  };
  const baseName = () => capture.name.replace(/\.(pcapng|pcap|txt|log|csv)$/i, "");
  const open = () => {
    const shown = plural(capture.matched, "packet");
    dialog.replaceChildren(element("h2", { id: "export-title" }, "Export"),
      element("ul", { className: "actions" },
        item(`The ${shown} that the list shows, as a table (CSV)`, act(() => saveRows(capture, columns, baseName()))),
        item(`The ${shown} that the list shows, with all fields (text)`, act(() => saveTrees(capture, baseName()))),
        isPcapng(capture.bytes) && item(`The ${shown} that the list shows, as a capture (pcapng)`, act(() => savePackets(capture, baseName()))),
        item("The whole capture", act(() => save(capture.bytesName, capture.bytes, "application/vnd.tcpdump.pcap"))),
        item(capture.log ? "The log, explained line by line (text)" : "The capture as an explained log (text)", act(() => saveLog(capture, baseName()))),
        item("Long data that Wireshark has put together (files)", act(() => saveWholes(capture, baseName())))),
      button("Close", () => dialog.close()));
    dialog.showModal();
  };
  return { root: dialog, open };
}

const item = (text, onclick) => element("li", {}, button(text, onclick));

// Calls `take` with all rows that the filter leaves.
async function takeEach(capture, words, take, filter = capture.filter) {
  const viewer = await capture.viewer;
  await capture.long(words, async (options) => {
    for await (const row of everyRow(viewer, filter, options)) await take(row, viewer);
  });
}

async function saveRows(capture, columns, name) {
  const rows = [columns.map(({ title }) => title)];
  await takeEach(capture, "Exporting rows", ({ cells }) => rows.push(cells));
  save(`${name}.csv`, asCsv(rows), "text/csv");
}

const lines = (tree, depth) => tree.map((one) => `${" ".repeat(4 * depth)}${textOf(one)}\n${lines(one.tree, depth + 1)}`).join("");

async function saveTrees(capture, name) {
  const texts = [];
  await takeEach(capture, "Exporting fields", async ({ number }, viewer) => texts.push(lines((await viewer.call("packet", [number])).tree, 0)));
  save(`${name}.txt`, new Blob([texts.join("\n")], { type: "text/plain" }));
}

async function savePackets(capture, name) {
  const numbers = new Set();
  await takeEach(capture, "Exporting packets", ({ number }) => numbers.add(number));
  save(`${name}-shown.pcapng`, only(capture.bytes, numbers));
}

async function saveLog(capture, name) {
  const out = "out.txt";
  const [words, files] = capture.log
    ? [["annotate", "log.txt", "-o", out, ...(capture.log.pattern ? [`--regex=${capture.log.pattern}`] : [])], { "log.txt": capture.log.bytes }]
    : [["log", "a.pcapng", "-o", out], { "a.pcapng": capture.bytes }];
  const { code, said, written } = await capture.long("Explaining", (options) => callTap("command", [words, files, [out]], options));
  if (code) throw new Error(said.trim());
  save(`${name}-explained.txt`, written[out]);
}

async function saveWholes(capture, name) {
  let count = 0;
  await takeEach(capture, "Looking for long data", async ({ number }, viewer) => {
    const { sources } = await viewer.call("packet", [number]);
    for (const { name: source, bytes } of sources.slice(1)) {
      count++;
      save(`${name}, packet ${number}, ${source.replace(/[^\w ,.-]/g, "_")}.bin`, bytes, "application/octet-stream");
    }
  }, WHOLE);
  if (!count) throw new Error("This capture has no long data: nothing was put together from several telegrams");
}
