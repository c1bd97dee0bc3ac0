// SPDX-License-Identifier: GPL-2.0-or-later
// Checks answers as the page does. The argument names a file with JSON: a list of {capture, preferences, tried}, where
// tried is a list of [ask, text]. Prints for each the list of {right, say}.

import { readFileSync } from "node:fs";

import { USUAL } from "../src/dissect/dissector.js";
import { check } from "../src/learn/answers.js";
import { TASK, startDissector } from "./parts.mjs";

const dissector = await startDissector();
const matched = async (filter) => dissector.rows(TASK, filter, 0, 1).matched;
const found = [];
for (const { capture, preferences, tried } of JSON.parse(readFileSync(process.argv[2], "utf8"))) {
  dissector.prefer({ ...USUAL, ...preferences });
  dissector.open(TASK, readFileSync(capture));
  const said = [];
  for (const [ask, text] of tried) said.push(await check(ask, text, matched));
  found.push(said);
}
process.stdout.write(JSON.stringify(found));
