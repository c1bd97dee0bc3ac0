// SPDX-License-Identifier: GPL-2.0-or-later
// A page that sistap has made, in a frame in which no script runs, with a button that saves it. Its links work, and its
// display filters are links.

import { button, element, save } from "./dom.js";

// In such a frame, #x is a place of the page around it. This is the frame's own address.
const FRAMED = "about:srcdoc";

export function framed(title, { applyFilter = null } = {}) {
  const frame = element("iframe", { title, sandbox: "allow-same-origin", className: "report-frame", hidden: true });
  const bar = element("p", { className: "report-bar" });
  // An empty frame has no document that the page may see.
  if (applyFilter) frame.addEventListener("load", () => frame.contentDocument && linkFilters(frame.contentDocument, applyFilter));
  return {
    frame,
    bar,
    show(page, name) {
      frame.srcdoc = new TextDecoder().decode(page).replaceAll('href="#', `href="${FRAMED}#`);
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

function linkFilters(page, applyFilter) {
  for (const code of page.querySelectorAll("code")) {
    const act = () => applyFilter(code.textContent);
    Object.assign(code, { tabIndex: 0, role: "link", title: "Show these packets" });
    code.style.cursor = "pointer";
    code.style.textDecoration = "underline";
    code.addEventListener("click", act);
    code.addEventListener("keydown", ({ key }) => key === "Enter" && act());
  }
}
