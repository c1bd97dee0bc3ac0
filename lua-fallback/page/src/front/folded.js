// SPDX-License-Identifier: GPL-2.0-or-later
// A line that ends where its room ends, and a button that shows the rest in place.

import { button, element } from "./dom.js";

// `content` is filled by others.
export function folded(content, name) {
  const more = button("More", () => set(!root.classList.contains("unfolded")), { className: "small", "aria-expanded": "false", hidden: true });
  const root = element("div", { className: "folded", onfocusin: ({ target }) => isCutOff(target, content) && set(true) }, content, more);
  const look = () => (more.hidden = !root.classList.contains("unfolded") && content.scrollWidth <= content.clientWidth);
  const set = (isOpen) => {
    root.classList.toggle("unfolded", isOpen);
    content.scrollLeft = 0;
    more.textContent = isOpen ? "Less" : "More";
    more.setAttribute("aria-expanded", isOpen);
    look();
  };
  more.setAttribute("aria-label", `More or less of: ${name}`);
  new ResizeObserver(look).observe(content);
  new MutationObserver(look).observe(content, { childList: true, subtree: true, characterData: true });
  return root;
}

// Whoever goes there with Tab has to see it.
const isCutOff = (one, content) => content.contains(one) && one.getBoundingClientRect().right > content.getBoundingClientRect().right;
