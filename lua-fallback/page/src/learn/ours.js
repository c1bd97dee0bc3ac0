// SPDX-License-Identifier: GPL-2.0-or-later
// HTML of the project's own texts, made when the page was built. It is the only HTML that the page takes.

import { element } from "../front/dom.js";

export function ours(tag, html, attributes = {}) {
  const made = element(tag, attributes);
  made.append(...new DOMParser().parseFromString(html, "text/html").body.childNodes);
  return made;
}
