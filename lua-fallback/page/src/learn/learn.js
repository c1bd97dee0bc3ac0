// SPDX-License-Identifier: GPL-2.0-or-later
// The course: the list of its lessons, a lesson beside its packets, and the sheets.

import { element, find } from "../front/dom.js";
import { partText } from "../front/parts.js";
import { courseList } from "./course.js";
import { Lesson } from "./lesson.js";
import { ours } from "./ours.js";
import { Progress } from "./progress.js";

export function learnView(capture, packetsView, { showing, applyFilter }) {
  const progress = new Progress();
  const root = element("div", { className: "learn" });
  let course = null; // a promise
  let shown = "";

  root.enter = () => showing(async () => {
    course ??= partText("course.json").then(JSON.parse);
    const found = await course;
    const name = decodeURIComponent(location.hash.split("/")[1] ?? "");
    if (name === shown && name !== "") return;
    shown = name;
    const lesson = found.lessons.find((one) => one.name === name);
    packetsView.hidden = !lesson;
    if (lesson) await new Lesson(lesson, { root, lessons: found.lessons, capture, packetsView, progress, showing, applyFilter }).open();
    else root.replaceChildren(sheetOf(name, found) ?? courseList(found, progress, showing));
    find("#main").scrollTop = 0;
  });
  // Another view needs the packets in their own place.
  root.leave = () => {
    shown = "";
    packetsView.classList.remove("raw");
    root.replaceChildren();
  };

  return root;
}

// What is beside the lessons: the words, and what hangs on the wall. Undefined if it is none of these.
function sheetOf(name, { glossary, papers }) {
  const back = () => element("p", {}, element("a", { href: "#learn" }, "Course"));
  if (name === "glossary") return element("article", { className: "page" }, back(), element("h1", {}, "Glossary"), ours("div", glossary));
  const [, title, svg] = papers.find(([id]) => id === name) ?? [];
  if (!svg) return undefined;
  const address = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
  return element("article", { className: "page paper" }, back(), element("h1", { className: "visually-hidden" }, title),
    element("img", { src: address, alt: title }));
}
