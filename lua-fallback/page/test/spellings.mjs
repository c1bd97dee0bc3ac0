// SPDX-License-Identifier: GPL-2.0-or-later
// Checks answers without Wireshark. The argument names a file with JSON: a list of [ask, text, packets], where packets says
// what each filter leaves. Prints the list of {right, say}.

import { readFileSync } from "node:fs";

import { check } from "../src/learn/answers.js";

// "(a) && (b)" leaves what both leave, and a filter that is not in the list is not valid.
function counter(packets) {
  return async (filter) => {
    const [one, other] = filter.split(/^\(|\) && \(|\)$/).filter(Boolean).map((part) => packets[part]);
    if (!one) throw new Error(`${filter} is no filter`);
    return one.filter((number) => !other || other.includes(number)).length;
  };
}

const tried = JSON.parse(readFileSync(process.argv[2], "utf8"));
process.stdout.write(JSON.stringify(await Promise.all(tried.map(([ask, text, packets]) => check(ask, text, counter(packets))))));
