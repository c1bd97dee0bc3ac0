// SPDX-License-Identifier: GPL-2.0-or-later
// The page of `sistap report` about the capture that is open.

import { button, element } from "./dom.js";
import { framed } from "./framed.js";
import { judge } from "./judging.js";

export function reportView(capture, { applyFilter, showing, tellLimits }) {
  const page = framed("Report", { applyFilter });
  const root = element("section", { className: "report", "aria-labelledby": "report-title" },
    element("h1", { id: "report-title", className: "visually-hidden" }, "Report"), page.bar, page.frame);
  let shown = null;
  root.enter = () => showing(async () => {
    if (!capture.found) await capture.long("Making the report", (options) => judge(capture, options));
    if (shown === capture.page) return;
    shown = capture.page;
    page.show(shown, `${capture.name}.html`);
    if (!capture.found.not_judged.length) return;
    page.bar.append(" The capture does not set TzA or TrS. If you know them, tell them here: ", button("Limits", tellLimits));
  });
  for (const event of ["opened", "grown"]) {
    capture.addEventListener(event, () => {
      shown = null;
      page.clear();
    });
  }
  return root;
}
