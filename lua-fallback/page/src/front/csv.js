// SPDX-License-Identifier: GPL-2.0-or-later
// Tables as comma-separated values, for spreadsheets and from sistap.

// A text that a spreadsheet would calculate gets a ' before it, as in `sistap parameters --csv`; numbers with units stay.
const FORMULA = /^[=+\-@\t\r]/, QUANTITY = /^[+-][\d.,]+(e[+-]?\d+)?( [\p{L}\p{N}_°%/²³·^]*)?$/u;
const safe = (cell) => (FORMULA.test(cell) && !QUANTITY.test(cell) ? `'${cell}` : cell);
const quoted = (cell) => (/[",\r\n]/.test(cell) ? `"${cell.replaceAll('"', '""')}"` : cell);

export const asCsv = (rows) => rows.map((row) => `${row.map((cell) => quoted(safe(cell))).join(",")}\r\n`).join("");

// Returns rows of texts.
export function fromCsv(text) {
  const rows = [[]];
  for (const [, inQuotes, plain, end] of text.matchAll(/(?:"([^"]*(?:""[^"]*)*)"|([^",\r\n]*))(,|\r?\n|$)/g)) {
    rows.at(-1).push((inQuotes?.replaceAll('""', '"') ?? plain).replace(/^'(?=[=+\-@\t\r])/, ""));
    if (end !== ",") rows.push([]);
  }
  return rows.filter((row) => row.length > 1);
}
