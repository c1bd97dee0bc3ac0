// SPDX-License-Identifier: GPL-2.0-or-later
// A conversation that is explained byte by byte: above the rows of each telegram stand its bytes, to be clicked.

import { button, element, findAll } from "../front/dom.js";

export function explain(text) {
  for (const table of text.querySelectorAll("table.telegram.bytes")) {
    const packets = Map.groupBy(findAll("tbody tr", table), (row) => row.cells[0].textContent);
    table.closest(".wide").replaceWith(...Array.from(packets, ([packet, rows]) => telegram(packet, rows)));
  }
}

function telegram(packet, rows) {
  const bytes = rows.map((row) => button(row.cells[1].textContent, () => choose(row), { className: "bytes-of" }));
  const choose = (chosen) => rows.forEach((row, place) => {
    row.classList.toggle("chosen", row === chosen);
    bytes[place].setAttribute("aria-pressed", String(row === chosen));
    if (row === chosen) row.scrollIntoView({ block: "nearest" });
  });
  for (const row of rows) {
    row.cells[0].remove();
    row.addEventListener("click", () => choose(row));
  }
  return element("section", { className: "explained", "aria-label": `Telegram ${packet}` },
    element("p", {}, element("a", { className: "packet", href: `#packet-${packet}`, title: `Packet ${packet}` }, packet), " ", ...bytes),
    element("table", {}, element("tbody", {}, ...rows)));
}
