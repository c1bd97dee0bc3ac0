// SPDX-License-Identifier: GPL-2.0-or-later
// A lesson on paper: its text and questions, all packets, and on pages of their own the answers.

import { Stopped } from "../protocol.js";
import { element, table } from "../front/dom.js";
import { readProfile } from "../front/profile.js";
import { ours } from "./ours.js";
import { hex } from "./picture.js";
import { telegramOf } from "./workbench.js";

const MOST = 400; // packets; of a longer capture the first
const MOST_BYTES = 40; // of a telegram
const BYTES = 3; // the column

export async function printLesson({ title, text, questions }, capture) {
  const packets = await capture.long("Preparing the print", (options) => packetsOf(capture, options));
  const words = packets.length < capture.packets ? `The first ${packets.length} of ${capture.packets} packets` : "All packets";
  const sheet = element("div", { className: "print-only" }, ours("h1", title), ours("div", text),
    element("h2", {}, "Questions"), ...questions.map(asked),
    element("h2", {}, words), table([["No.", "Time", "Telegram", "Bytes"], ...packets], { name: "Packets", cell: asCode }),
    element("div", { className: "new-page" }, element("h2", {}, "Answers"), ...questions.map(answered)));
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

const section = (question, ...below) =>
  element("section", { className: "question" }, ours("h3", `${question.number}. ${question.text}`), ...below);

const asked = (question) => section(question, ours("div", question.lead), ...question.asks.map(({ prompt, choices }) => {
  const line = ours("p", prompt);
  line.append(": ", choices.join(" / ") || "____________________");
  return line;
}));

const answered = (question) => section(question,
  element("p", {}, question.asks.map(({ accepted }) => accepted.join(" or ")).join("; ")), ours("div", question.answer));
