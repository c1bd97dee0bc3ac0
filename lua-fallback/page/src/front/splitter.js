// SPDX-License-Identifier: GPL-2.0-or-later
// A bar that changes the height of what stands above it: with the pointer, or with the arrow keys.

import { element } from "./dom.js";

const LEAST = 90, STEP = 24; // pixels

export function splitter(above) {
  const set = (height) => {
    above.style.flex = `0 0 ${Math.max(LEAST, Math.min(height, innerHeight - 2 * LEAST))}px`;
    bar.setAttribute("aria-valuenow", Math.round((100 * above.offsetHeight) / innerHeight));
  };
  const bar = element("div", { className: "splitter", role: "separator", tabIndex: 0, "aria-orientation": "horizontal",
    "aria-label": "Height of the packet list", "aria-valuenow": 50, onpointerdown: (event) => {
      bar.setPointerCapture(event.pointerId);
      bar.onpointermove = ({ clientY }) => set(clientY - above.getBoundingClientRect().top);
    }, onpointerup: () => (bar.onpointermove = null), onkeydown: (event) => {
      const step = { ArrowUp: -STEP, ArrowDown: STEP }[event.key];
      if (!step) return;
      event.preventDefault();
      set(above.offsetHeight + step);
    } });
  return bar;
}
