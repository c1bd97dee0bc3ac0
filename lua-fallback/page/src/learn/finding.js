// SPDX-License-Identifier: GPL-2.0-or-later
// A finding: a few sentences to somebody. Who has written it sees the points that it should have, and ticks those that it has.

import { element } from "../front/dom.js";
import { ours } from "./ours.js";

const SHORTEST = 60; // characters

// What is written is kept as {text}; the points are ticked anew.
export function findingField({ points }, { id, text, note }) {
  const area = element("textarea", { id, rows: 4, value: text, spellcheck: true, oninput: () => note(area.value) });
  const boxes = points.map((_, place) => element("input", { type: "checkbox", id: `${id}-point-${place}` }));
  const rubric = element("fieldset", { className: "points", hidden: true }, element("legend", {}, "Tick what your text has:"),
    ...points.map((point, place) => {
      const line = element("p", {}, boxes[place], " ");
      line.append(ours("label", point, { htmlFor: boxes[place].id }));
      return line;
    }));

  async function judged() {
    if (area.value.trim().length < SHORTEST) return { right: null, say: "Write it first, in two sentences or more." };
    if (rubric.hidden) {
      rubric.hidden = false;
      return { right: null, say: "Compare your text with the points above, mend it, and check again." };
    }
    const count = boxes.filter(({ checked }) => checked).length;
    return { right: count === boxes.length, say: `${count} of ${boxes.length} points.` };
  }

  return { root: element("div", {}, area, rubric), judged };
}
