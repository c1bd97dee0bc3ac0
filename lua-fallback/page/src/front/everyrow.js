// SPDX-License-Identifier: GPL-2.0-or-later
// All rows that a filter leaves, in portions.

import { Stopped } from "../protocol.js";

const TOGETHER = 500; // rows that are fetched at once

// `viewer` is the Wireshark that shows the packets; `signal` and `progress` are those of Capture.long.
export async function* everyRow(viewer, filter, { signal, progress }) {
  for (let skip = 0, matched = 1; skip < matched; skip += TOGETHER) {
    const found = await viewer.call("rows", [filter, skip, TOGETHER]);
    ({ matched } = found);
    for (const row of found.rows) {
      if (signal.aborted) throw new Stopped();
      yield row;
    }
    progress(Math.min((skip + TOGETHER) / Math.max(matched, 1), 1));
  }
}
