// SPDX-License-Identifier: GPL-2.0-or-later
// The statistics of sis.lua, which prints them as text, as tables.

import { asCsv } from "./csv.js";
import { button, element, save, table } from "./dom.js";

const NUMBER = /^-?[\d.]+$/;
const TIMES = { "Min SRT": "Shortest (ms)", "Max SRT": "Longest (ms)", "Avg SRT": "Mean (ms)" }; // Wireshark's are in s
const OF_VALUES = / \(us\) +\d+$/; // a line whose values are not printed: its count would look like one

// Returns {title, rows}; the first row is the head.
function parsed(text) {
  return text.split("\n\n").map((block) => block.trim()).filter(Boolean).map((block) => {
    const [title, ...lines] = block.split("\n");
    const rows = /^Index /.test(lines[0]) ? inMs(lines.map(spaced)) : [["", "Telegrams"], ...lines.filter((line) => !OF_VALUES.test(line)).map(indented)];
    return { title: title.replace(/:$/, ""), rows };
  });
}

const spaced = (line) => line.trim().split(/ {2,}/);

const inMs = ([head, ...rows]) => [head.map((words) => TIMES[words] ?? words),
  ...rows.map((row) => row.map((text, place) => (head[place] in TIMES ? (1000 * Number(text)).toFixed(3) : text)))];

function indented(line) {
  const [, blanks, words, count] = line.match(/^( *)(.*?) +(\d+)$/) ?? [null, "", line, ""];
  return [`${" ".repeat(2 * blanks.length)}${words}`, count];
}

export function statisticsView(capture, { applyFilter, showing }) {
  const body = element("div", {});
  const root = element("section", { className: "page", "aria-labelledby": "statistics-title" },
    element("h1", { id: "statistics-title" }, "Statistics"), body);
  root.enter = () => showing(async () => {
    const { statistics } = await capture.figures();
    body.replaceChildren(...parsed(statistics).map((found) => one(found, applyFilter)));
  });
  capture.addEventListener("opened", () => body.replaceChildren());
  return root;
}

function one({ title, rows }, applyFilter) {
  const [head, ...body] = rows;
  const numeric = head.map((_, place) => place).filter((place) => place > 0 && body.every((row) => !row[place] || NUMBER.test(row[place])));
  const cell = (text, place) => {
    const filter = place === 0 && text.includes("Station ") && text.replace(/.*Station /, "sis.station == ");
    return filter ? button(text, () => applyFilter(filter), { className: "link", title: filter }) : text;
  };
  return element("div", { className: "statistic" }, element("h2", {}, title), table(rows, { name: title, numeric, cell }),
    button("Save as CSV", () => save(`${title}.csv`, asCsv(rows), "text/csv")));
}
