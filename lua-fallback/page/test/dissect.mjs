// SPDX-License-Identifier: GPL-2.0-or-later
// Prints what the page shows of captures, as JSON: of each file, named by arguments, {columns, trees}. The argument
// "--prefer NAME VALUE" sets a preference for all of them.

import { readFileSync } from "node:fs";

import { TASK, startDissector } from "./parts.mjs";

const words = process.argv.slice(2);
const preferences = {};
while (words[0] === "--prefer") {
  const [, name, value] = words.splice(0, 3);
  preferences[name] = value;
}
const dissector = await startDissector();
dissector.prefer(preferences);
const found = {};
for (const path of words) {
  const { packets } = dissector.open(TASK, readFileSync(path));
  found[path] = {
    columns: dissector.rows(TASK, "", 0, 0).rows.map(({ cells }) => cells),
    trees: Array.from({ length: packets }, (_, place) => dissector.packet(place + 1).tree),
  };
}
if (dissector.complaints.length) throw new Error(dissector.complaints.join("\n"));
process.stdout.write(JSON.stringify(found));
