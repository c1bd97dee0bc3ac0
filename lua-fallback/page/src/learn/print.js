// SPDX-License-Identifier: GPL-2.0-or-later
// A lesson on paper: its text with the tasks, and all packets. No answer is on it: those are for the teacher.

import { Stopped } from "../protocol.js";
import { element, table } from "../front/dom.js";
import { readProfile } from "../front/profile.js";
import { ours } from "./ours.js";
import { hex } from "./picture.js";
import { telegramOf } from "./workbench.js";

const MOST = 400; // packets; of a longer capture the first
const MOST_BYTES = 40; // of a telegram
const BYTES = 3; // the column

export async function printLesson({ title, text, sections }, capture) {
  const packets = await capture.long("Preparing the print", (options) => packetsOf(capture, options));
  const words = packets.length < capture.packets ? `The first ${packets.length} of ${capture.packets} packets` : "All packets";
  printed(ours("h1", title), ours("div", text),
    ...sections.flatMap((section) => [element("h2", {}, section.title), ours("div", section.text), ...section.tasks.map(asked)]),
    element("h2", {}, words), table([["No.", "Time", "Telegram", "Bytes"], ...packets], { name: "Packets", cell: asCode }));
}

// Prints what the page does not show.
export function printed(...parts) {
  const sheet = element("div", { className: "print-only" }, ...parts);
  document.body.append(sheet);
  document.body.classList.add("printing");
  addEventListener("afterprint", () => {
    sheet.remove();
    document.body.classList.remove("printing");
  }, { once: true });
  print();
}

const asCode = (text, place) => (place === BYTES ? element("code", {}, text) : text);

async function packetsOf(capture, { signal, progress }) {
  const viewer = await capture.viewer;
  const { rows } = await viewer.call("rows", ["", 0, MOST]);
  const { columns } = await readProfile();
  const [number, time, telegram] = ["%m", "%t", "%i"].map((format) => columns.findIndex((column) => column.format === format));
  const found = [];
  for (const { number: packet, cells } of rows) {
    if (signal.aborted) throw new Stopped();
    const bytes = telegramOf(await viewer.call("packet", [packet]))?.bytes ?? [];
    const more = bytes.length > MOST_BYTES ? [`and ${bytes.length - MOST_BYTES} more`] : [];
    found.push([cells[number], Number(cells[time]).toFixed(4), cells[telegram], [...bytes.slice(0, MOST_BYTES).map(hex), ...more].join(" ")]);
    progress(found.length / rows.length);
  }
  return found;
}

const LINE = "_".repeat(24), LINES = 4; // to be filled in
const LONG = ["finding", "telegram"]; // kinds that need several lines

const asked = ({ number, text, lead, blanks }) => element("section", { className: "task" }, ours("h3", `${number}. ${text}`), ours("div", lead),
  ...blanks.map(({ prompt, kind, choices, unit }) => {
    const line = ours("p", prompt);
    line.append(": ", choices.join(" / ") || `${LINE.repeat(LONG.includes(kind) ? LINES : 1)} ${kind === "number" ? unit : ""}`);
    return line;
  }));
