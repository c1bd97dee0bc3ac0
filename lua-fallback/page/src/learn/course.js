// SPDX-License-Identifier: GPL-2.0-or-later
// The list of the lessons; results of learners, for a teacher.

import { askForget } from "../front/dialogs.js";
import { button, element, plural, save, table } from "../front/dom.js";
import { visible } from "../front/files.js";
import { printCertificate, undone } from "./certificate.js";
import { ours } from "./ours.js";
import { readResults } from "./progress.js";

const WORDS = `One machine, one week: each lesson is a problem at the winder. Read, predict, open the packets, build, and prove. What \
you type is checked at once.`;

const tasksOf = ({ sections }) => sections.flatMap(({ tasks }) => tasks);

export function courseList({ days, lessons, papers }, progress, showing) {
  const right = lessons.reduce((sum, { name }) => sum + progress.right(name), 0);
  const count = lessons.reduce((sum, lesson) => sum + tasksOf(lesson).length, 0);
  const week = lessons.slice(0, days.reduce((sum, [, ofDay]) => sum + ofDay, 0));
  const links = [["glossary", "Glossary"], ...papers].flatMap(([id, title]) => [" ", element("a", { href: `#learn/${id}` }, title)]);
  const root = element("article", { className: "page" });
  const renew = () => root.replaceWith(courseList({ days, lessons, papers }, progress, showing));
  root.append(element("h1", {}, "A course to do"), element("p", {}, WORDS),
    element("p", {}, `${right} of ${count} tasks done.`,
      progress.isKept ? "" : " This browser does not let the page keep your progress.", ...links),
    ...byDays(days, lessons).flatMap(([day, ofDay]) => [element("h2", {}, day),
      element("ul", { className: "lessons" }, ...ofDay.map((lesson) => item(lesson, progress)))]),
    element("h2", {}, "Results"), ...ofLearner(week, progress, renew), ...ofTeacher(lessons, showing));
  return root;
}

// Lessons after the week show other roads to a drive.
function byDays(days, lessons) {
  let begin = 0;
  return [...days, ["Other roads", lessons.length]].map(([day, count]) => [day, lessons.slice(begin, begin += count)]);
}

function item(lesson, progress) {
  const { name, title, aim, minutes } = lesson;
  const right = progress.right(name), count = tasksOf(lesson).length;
  return element("li", {},
    element("a", { href: `#learn/${name}` }, title), " ",
    element("progress", { max: count, value: right, "aria-label": "Tasks done" }), " ",
    element("small", {}, `${right} of ${count}, ${minutes} minutes`), ours("p", aim));
}

function ofLearner(week, progress, renew) {
  const name = element("input", { type: "text", id: "learner" }), left = undone(week, progress, tasksOf);
  const fileName = () => `results ${name.value.replace(/[^\p{L}\p{M}\p{N}_ -]/gu, "_") || "of somebody"}.json`;
  return [element("p", { className: "form-line" }, element("label", { htmlFor: "learner" }, "Your name"), name,
    button("Print a certificate", () => printCertificate(name.value, week, progress, tasksOf), left ? { disabled: true, title: `${plural(left, "task")} of the week left` } : {}),
    button("Save my results", () => save(fileName(), progress.results(name.value), "application/json")),
    button("Forget my progress", () => askForget(plural(progress.answers, "answer"), () => {
      progress.forget();
      renew();
    })))];
}

function ofTeacher(lessons, showing) {
  const holder = element("div", {});
  const readAll = async () => {
    const files = [...chooser.files];
    chooser.value = ""; // so that the same file can be chosen again
    const read = await Promise.all(files.map(readFile));
    const results = read.filter(({ trouble }) => !trouble), others = read.filter(({ trouble }) => trouble);
    holder.replaceChildren(...(results.length ? [classTable(lessons, results), ...findingsOf(lessons, results)] : []), ...notRead(others));
  };
  const chooser = element("input", { type: "file", id: "results", multiple: true, accept: ".json", className: "visually-hidden",
    onchange: () => showing(readAll) });
  const label = element("label", { htmlFor: "results", className: "button" }, "Read the results of a class");
  return [element("p", {}, "For teachers: ", chooser, label), holder];
}

// What a learner has saved, or why it cannot be read: {file, trouble}.
async function readFile(file) {
  try {
    return readResults(await file.text());
  } catch ({ message }) {
    return { file: visible(file.name), trouble: message };
  }
}

// A class has many files: the wrong ones are named.
function notRead(others) {
  if (!others.length) return [];
  return [element("p", { role: "status" }, `${plural(others.length, "file")} could not be read:`),
    element("ul", { className: "not-read" }, ...others.map(({ file, trouble }) => element("li", {}, element("b", {}, file), `: ${trouble}`)))];
}

function classTable(lessons, results) {
  const head = ["Name", ...lessons.map(({ title }) => title.match(/^\d+/)?.[0] ?? title), "Saved"];
  const cell = (one, lesson) => {
    const shown = one.shown(lesson.name);
    return `${one.right(lesson.name)}/${tasksOf(lesson).length}${shown ? ` (${shown} shown)` : ""}`;
  };
  const rows = results.sort((one, other) => one.name.localeCompare(other.name))
    .map((one) => [visible(one.name) || "no name", ...lessons.map((lesson) => cell(one, lesson)), one.when.slice(0, 10)]);
  return table([head, ...rows], { name: "Results of the class" });
}

// What the learners have written, for a teacher to read: they judged it themselves.
function findingsOf(lessons, results) {
  const written = lessons.flatMap((lesson) => tasksOf(lesson).flatMap(({ number, blanks }) =>
    blanks.flatMap(({ kind, points }, place) => (kind === "finding" ? [{ lesson, points, field: `blank-${number}-${place}` }] : []))));
  return written.flatMap(({ lesson, points, field }) => {
    const texts = results.map((one) => [one.name, one.typed(lesson.name)[field]]).filter(([, text]) => text);
    if (!texts.length) return [];
    return [element("h3", {}, `Findings of lesson ${lesson.title}`), element("ul", {}, ...points.map((point) => ours("li", point))),
      ...texts.map(([name, text]) => element("blockquote", {}, element("b", {}, `${visible(name)}: `), visible(String(text))))];
  });
}
