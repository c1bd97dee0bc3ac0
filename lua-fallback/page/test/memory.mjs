// SPDX-License-Identifier: GPL-2.0-or-later
// Fetches all rows of a capture, and filters it: node memory.mjs CAPTURE. Prints {memory} as JSON, in bytes.

import { readFileSync } from "node:fs";

import { TASK, startDissector } from "./parts.mjs";

const TOGETHER = 500;
const dissector = await startDissector();
const { packets } = dissector.open(TASK, readFileSync(process.argv[2]));
for (let skip = 0; skip < packets; skip += TOGETHER) dissector.rows(TASK, "", skip, TOGETHER);
for (const filter of ["sis.status > 0", "sis.reaction_time > 1", "sis.parameter"]) dissector.rows(TASK, filter, 0, 1);
process.stdout.write(JSON.stringify({ memory: dissector.memory }));
