// SPDX-License-Identifier: GPL-2.0-or-later
// The bus of a lesson, to play and record in the page.

import { button, element } from "../front/dom.js";
import { Live } from "../front/live.js";
import { callTap } from "../front/tap.js";

const LONGEST = 60; // seconds of a bus that is played live

// The name of a lesson's capture.
export const fileOf = ({ name }) => `${name}.pcapng`;

export function busOf(lesson, capture, showing) {
  if (!lesson.scenario || lesson.seconds > LONGEST) return [];
  const play = () => showing(async () => {
    await capture.long("Starting sistap", (options) => callTap("play", ["lesson.toml", 1, lesson.scenario], options));
    const begun = performance.now();
    const next = async () => {
      const now = (performance.now() - begun) / 1000;
      const result = await callTap("step", [Math.min(now, lesson.seconds)]);
      return { ...result, isOver: result.isOver || now > lesson.seconds };
    };
    const { preferences } = lesson;
    await new Live(capture, { title: "The bus of this lesson plays", name: fileOf(lesson), controls: [], preferences, next }).run();
  });
  return [element("p", { className: "note" }, "The recording is open beside this text. Or make it yourself: ",
    button(`Play this bus for ${lesson.seconds} s and record it`, play))];
}
