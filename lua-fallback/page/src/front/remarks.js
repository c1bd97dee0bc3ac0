// SPDX-License-Identifier: GPL-2.0-or-later
// What is to be said of what is open: its `trouble`, and what sistap said of what it made a capture of. capture.log has
// `said` and the lines that it could not read, `unread`; capture.imported has `said`, the bytes of the file, and `told`,
// the options of a person.

import { button, element } from "./dom.js";

const said = (texts, ...more) => (texts.length ? [element("p", { className: "note" }, texts.map((text) => text.replace(/\.?$/, ".")).join(" "), ...more)] : []);

const unread = (texts) => (texts.length ? [element("details", { className: "note" },
  element("summary", {}, `Lines that could not be read: ${texts.length}`), ...texts.map((text) => element("p", {}, text)))] : []);

// `again` asks for other options.
export function remarksOf({ trouble, log, imported }, again) {
  const first = said(trouble ? [trouble] : []);
  if (imported) return [...first, ...said(imported.said, " ", button("Other settings", again, { className: "link" }))];
  return log ? [...first, ...said(log.said), ...unread(log.unread)] : first;
}
