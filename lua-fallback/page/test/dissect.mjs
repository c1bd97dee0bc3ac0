// SPDX-License-Identifier: GPL-2.0-or-later
// Prints what the page shows of captures, as JSON: of each file, named by arguments, {columns, step, trees}; `columns` are
// all rows, `trees` those of at most MOST packets: of each, or of one in so many as `step` says. The arguments are
// MOST, preferences and files of the profile as JSON, both texts by name, and the files.

import { readFileSync } from "node:fs";

import { TASK, startDissector } from "./parts.mjs";

const [most, preferences, files, ...words] = process.argv.slice(2);
const dissector = await startDissector(JSON.parse(files));
dissector.prefer(JSON.parse(preferences));
const found = {};
for (const path of words) {
  const { packets } = dissector.open(TASK, readFileSync(path));
  const step = Math.ceil(packets / Number(most));
  found[path] = {
    columns: dissector.rows(TASK, "", 0, 0).rows.map(({ cells }) => cells),
    step,
    trees: Array.from({ length: Math.floor(packets / step) }, (_, place) => dissector.packet((place + 1) * step).tree),
  };
}
if (dissector.complaints.length) throw new Error(dissector.complaints.join("\n"));
process.stdout.write(JSON.stringify(found));
