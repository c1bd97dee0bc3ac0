// SPDX-License-Identifier: GPL-2.0-or-later
// What Wireshark's profile says that the page draws by itself: titles of the columns, filter buttons, graphs, and names of
// the rules that colour the packet list. Wireshark applies these rules.

import { partText } from "./parts.js";

// The texts in quotes of each line of a list.
const rows = (text) => text.split("\n").filter((line) => line.startsWith('"'))
  .map((line) => Array.from(line.matchAll(/"([^"]*)"/g), (found) => unescaped(found[1])));
const unescaped = (text) => text.replace(/\\x([0-9a-f]{2})/gi, (_, code) => String.fromCharCode(parseInt(code, 16)));

const DIGITS = { SEC: 0, DSEC: 1, CSEC: 2, MSEC: 3, USEC: 6, NSEC: 9 };

export async function readProfile() {
  const names = ["preferences", "recent", "dfilter_buttons", "io_graphs", "colorfilters"];
  const [preferences, recent, buttons, graphs, rules] = await Promise.all(names.map(partText));
  return { columns: columns(preferences, recent), buttons: buttonsOf(buttons), graphs: graphsOf(graphs), rules: rulesOf(rules) };
}

// Columns: {title, format, field, isRight, digits}; `field` is that of Wireshark, of a column that shows one; digits are
// those after the point of a time.
function columns(preferences, recent) {
  const texts = Array.from(preferences.slice(preferences.indexOf("gui.column.format")).matchAll(/"([^"]*)"/g), (found) => found[1]);
  const right = new Set(Array.from(recent.matchAll(/"([^"]*)", -?\d+:R/g), (found) => found[1]));
  const precision = recent.match(/gui\.time_precision: (\w+)/);
  return Array.from({ length: texts.length / 2 }, (_, place) => {
    const [title, format] = texts.slice(2 * place, 2 * place + 2);
    const digits = format === "%t" && precision ? DIGITS[precision[1]] : null;
    const field = format.match(/^%Cus:([\w.]+)/)?.[1];
    return { title, format, field, isRight: format === "%t" || format === "%m" || right.has(format.replace(/:0:R$/, "")), digits };
  });
}

const buttonsOf = (text) => rows(text).filter(([enabled]) => enabled === "TRUE")
  .map(([, name, filter, help]) => ({ name, filter, help }));

// Graphs that draw a field: {name, filter, colour, field}.
const graphsOf = (text) => rows(text).filter((row) => row[6])
  .map(([, name, filter, colour, , , field]) => ({ name, filter, colour, field }));

// Rules, in their order: {name, paper}; `paper` is the colour of a row as wiregasm tells it, with 8 of its 16 bits.
const rulesOf = (text) => Array.from(text.matchAll(/^@([^@]*)@.*?@\[(\d+),(\d+),(\d+)\]/gm), ([, name, ...colour]) =>
  ({ name, paper: `#${colour.map((part) => (part >> 8).toString(16).padStart(2, "0")).join("")}` }));
