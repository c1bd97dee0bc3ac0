// SPDX-License-Identifier: GPL-2.0-or-later
// A page that sistap has made, in a frame in which no script runs, with a button that saves it.

import { button, element, save } from "./dom.js";

export function framed(title) {
  const frame = element("iframe", { title, sandbox: "", className: "report-frame", hidden: true });
  const bar = element("p", { className: "report-bar" });
  return {
    frame,
    bar,
    show(page, name) {
      frame.srcdoc = new TextDecoder().decode(page);
      frame.hidden = false;
      bar.replaceChildren(button(`Save the ${title.toLowerCase()}`, () => save(name, page, "text/html")));
    },
    clear() {
      frame.removeAttribute("srcdoc");
      frame.hidden = true;
      bar.replaceChildren();
    },
  };
}
