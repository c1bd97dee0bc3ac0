// SPDX-License-Identifier: GPL-2.0-or-later
// A lesson on paper: its text and questions, all packets, and on pages of their own the answers.

import { element, table } from "../front/dom.js";
import { readProfile } from "../front/profile.js";
import { ours } from "./ours.js";

const MOST = 400; // packets; of a longer capture the first

export async function printLesson({ title, text, questions }, capture) {
  const packets = await packetsOf(capture);
  const words = packets.length < capture.packets ? `The first ${packets.length} of ${capture.packets} packets` : "All packets";
  const sheet = element("div", { className: "print-only" }, ours("h1", title), ours("div", text),
    element("h2", {}, "Questions"), ...questions.map(asked),
    element("h2", {}, words), table([["No.", "Time", "Telegram"], ...packets], { name: "Packets" }),
    element("div", { className: "new-page" }, element("h2", {}, "Answers"), ...questions.map(answered)));
  document.body.append(sheet);
  document.body.classList.add("printing");
  addEventListener("afterprint", () => {
    sheet.remove();
    document.body.classList.remove("printing");
  }, { once: true });
  print();
}

async function packetsOf(capture) {
  const { rows } = await (await capture.viewer).call("rows", ["", 0, MOST]);
  const { columns } = await readProfile();
  const [number, time, telegram] = ["%m", "%t", "%i"].map((format) => columns.findIndex((column) => column.format === format));
  return rows.map(({ cells }) => [cells[number], Number(cells[time]).toFixed(4), cells[telegram]]);
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
