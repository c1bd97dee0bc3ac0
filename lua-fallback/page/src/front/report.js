// SPDX-License-Identifier: GPL-2.0-or-later
// What `sistap report` says of the capture that is open, and its page.

import { button, element } from "./dom.js";
import { fileName } from "./files.js";
import { framed } from "./framed.js";
import { callTap } from "./tap.js";

const LIMITS = { "sis.tza_ms": "--tza", "sis.trs_ms": "--trs" }; // preferences that are options, too

// Returns a report in a format of sistap, as bytes. `options` are those of callTap.
export async function reported(capture, format, options) {
  const file = fileName(capture.bytesName), out = `.report.${format}`;
  const limits = Object.entries(LIMITS).flatMap(([name, option]) => {
    const limit = Number(capture.preferences[name] ?? 0);
    return limit ? [option, String(limit)] : [];
  });
  const { code, said, written } = await callTap("command",
    [["report", file, "-o", out, "--format", format, ...limits], { [file]: capture.bytes }, [out]], options);
  if (code) throw new Error(said.trim());
  return written[out];
}

// What a report says of a missing limit is for the command: here a button does it.
const ASKS_LIMIT = /add --(tza|trs) MS/;

export function reportView(capture, { showing, tellLimits }) {
  const page = framed("Report");
  const root = element("section", { className: "report", "aria-labelledby": "report-title" },
    element("h1", { id: "report-title", className: "visually-hidden" }, "Report"), page.bar, page.frame);
  let of = null; // the bytes that the report is about
  root.enter = () => of === capture.bytes || showing(async () => {
    of = capture.bytes;
    try {
      page.show(await capture.long("Making the report", (options) => reported(capture, "html", options)), `${capture.name}.html`);
      if (ASKS_LIMIT.test(page.frame.srcdoc)) page.bar.append(" The capture does not set TzA or TrS. If you know them, tell them here: ", button("Limits", tellLimits));
    } catch (error) {
      of = null;
      throw error;
    }
  });
  capture.addEventListener("opened", () => {
    of = null;
    page.clear();
  });
  return root;
}
