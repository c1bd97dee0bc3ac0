// SPDX-License-Identifier: GPL-2.0-or-later
// Keeps the packets of a lesson shut until its predictions are made: nobody learns from an answer that is read off.

import { button, element } from "../front/dom.js";

const BEFORE = ["Remember", "Predict"]; // sections

const WORDS = "First predict: the packets open when the tasks under Remember and Predict are done.";

// `kept` is the view of the packets; `changed` is called when a person opens it without predictions.
export function gateOf({ name, sections }, progress, { changed, kept }) {
  const numbers = sections.filter(({ title }) => BEFORE.includes(title)).flatMap(({ tasks }) => tasks.map(({ number }) => number));
  const open = () => numbers.filter((number) => !progress.of(name).answers[number]);
  const guarded = [kept];
  const root = element("div", { className: "gate" }, element("p", {}, WORDS),
    button("Open them now", () => {
      for (const number of open()) progress.answer(name, number, "shown");
      changed();
    }), element("p", {}, element("small", {}, "What is not answered then counts as shown.")));

  return {
    root,
    // Keeps an element shut, too: returns it.
    guard(one) {
      guarded.push(one);
      return one;
    },
    tell() {
      const isShut = open().length > 0;
      root.hidden = !isShut;
      for (const one of guarded) one.hidden = isShut;
    },
  };
}
