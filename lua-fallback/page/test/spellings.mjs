// SPDX-License-Identifier: GPL-2.0-or-later
// Checks answers without Wireshark. The argument names a file with JSON: a list of [ask, text]. Prints the list of {right, say}.

import { readFileSync } from "node:fs";

import { check } from "../src/learn/answers.js";

const tried = JSON.parse(readFileSync(process.argv[2], "utf8"));
process.stdout.write(JSON.stringify(await Promise.all(tried.map(([ask, text]) => check(ask, text)))));
