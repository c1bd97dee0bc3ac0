// SPDX-License-Identifier: GPL-2.0-or-later
// What `sistap report` says of the capture that is open. It is made once: the answer and the report show the same.

import { Stopped } from "../protocol.js";
import { fileName } from "./files.js";
import { callTap } from "./tap.js";

const LIMITS = { "sis.tza_ms": "--tza", "sis.trs_ms": "--trs" }; // preferences that are options, too

// Sets capture.found, the figures, and capture.page, the report as HTML; the event "judged" says so. `options` are those
// of callTap. Fails with Stopped if another capture is open at the end.
export async function judge(capture, options) {
  const { bytes, preferences } = capture;
  const words = Object.entries(LIMITS).flatMap(([name, option]) => {
    const limit = Number(preferences[name] ?? 0);
    return limit ? [option, String(limit)] : [];
  });
  const { page, figures } = await callTap("judge", [fileName(capture.bytesName), bytes, words], options);
  if (bytes !== capture.bytes || preferences !== capture.preferences) throw new Stopped();
  Object.assign(capture, { page, found: JSON.parse(new TextDecoder().decode(figures)) });
  capture.tell("judged");
}
