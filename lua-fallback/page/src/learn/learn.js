// SPDX-License-Identifier: GPL-2.0-or-later
// The course: a lesson beside the real packets, its words, and what can be tried.

import { button, element, find, plural } from "../front/dom.js";
import { partText } from "../front/parts.js";
import { busOf, fileOf } from "./bus.js";
import { courseList } from "./course.js";
import { linkText } from "./links.js";
import { ours } from "./ours.js";
import { printLesson } from "./print.js";
import { Progress } from "./progress.js";
import { questionOf } from "./question.js";
import { timeline } from "./timeline.js";
import { workbench } from "./workbench.js";

const MOVING = { "09-timing": 9, "11-damaged-line": 6, "17-wiring": 8 }; // lessons with a timeline, and its packet

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
    if (lesson) await openLesson(lesson, found.lessons);
    else root.replaceChildren(sheetOf(name, found) ?? courseList(found, progress, showing));
    find("#main").scrollTop = 0;
  });
  // Another view needs the packets in their own place.
  root.leave = () => {
    shown = "";
    root.replaceChildren();
  };

  async function openLesson(lesson, lessons) {
    const matched = async (filter) => (await (await capture.viewer).call("rows", [filter, 0, 1])).matched;
    const questions = lesson.questions.map((question) => questionOf(question, {
      kept: progress.of(lesson.name).typed, matched, showing,
      typed: (field, text) => progress.type(lesson.name, field, text),
      told: (how) => {
        const counts = progress.answer(lesson.name, question.number, how);
        showState(lesson);
        return counts;
      },
    }));
    const text = element("article", { className: "lesson-text" }, navigation(lesson, lessons, () => showing(() => printLesson(lesson, capture))),
      ours("h1", lesson.title),
      element("p", { className: "lesson-state", role: "status" }), ...busOf(lesson, capture, showing), ours("div", lesson.text),
      element("h2", { id: "questions" }, "Questions"), ...questions, ours("div", lesson.end), ...tools(lesson, capture));
    const packets = element("aside", { "aria-label": "Packets of the lesson" }, packetsView);
    root.replaceChildren(element("div", { className: "lesson" }, text, packets));
    linkText(text, { capture, showing, applyFilter });
    await capture.live?.stop();
    const bytes = Uint8Array.from(atob(lesson.capture), (letter) => letter.charCodeAt(0));
    await capture.open(fileOf(lesson), bytes, { preferences: lesson.preferences });
    showState(lesson);
  }

  function showState(lesson) {
    const { answers } = progress.of(lesson.name);
    const opened = progress.shown(lesson.name);
    find(".lesson-state", root).textContent = `${progress.right(lesson.name)} of ${plural(lesson.questions.length, "question")} answered\
${opened ? `, ${plural(opened, "answer")} shown` : ""}.`;
    for (const section of root.querySelectorAll(".question")) section.classList.toggle("done", answers[section.dataset.number] === "right");
  }

  return root;
}

function navigation(lesson, lessons, print) {
  const place = lessons.indexOf(lesson);
  const links = [["", "Course"], ["/glossary", "Glossary"]];
  for (const [other, words] of [[lessons[place - 1], "Previous"], [lessons[place + 1], "Next"]]) if (other) links.push([`/${other.name}`, words]);
  return element("p", { className: "lesson-links" }, ...links.flatMap(([to, words]) => [element("a", { href: `#learn${to}` }, words), " "]),
    button("Print", print));
}

// What can be tried with the packets of a lesson.
function tools(lesson, capture) {
  const selected = () => ({ bytes: capture.bytes, number: capture.number, packet: capture.packet });
  const moving = timeline(selected, lesson.preferences);
  if (lesson.name in MOVING) openAt(MOVING[lesson.name], lesson, moving, capture);
  return [element("h2", {}, "Try it"), moving, workbench(() => capture.packet)];
}

// Opens the timeline with a packet, as soon as the lesson has its packets.
function openAt(number, lesson, moving, capture) {
  capture.addEventListener("selected", function begin() {
    if (capture.name !== fileOf(lesson)) return;
    if (capture.number === number) {
      capture.removeEventListener("selected", begin);
      moving.open = true;
    } else {
      capture.goTo(number);
    }
  });
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
