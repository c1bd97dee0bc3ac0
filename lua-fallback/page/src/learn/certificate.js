// SPDX-License-Identifier: GPL-2.0-or-later
// What a learner has done in a week, on paper.

import { element, plural, table } from "../front/dom.js";
import { printed } from "./print.js";

// `lessons` are those of the week; `tasks(lesson)` are the tasks of one. Undone: how many are left.
export function undone(lessons, progress, tasks) {
  return lessons.reduce((sum, lesson) => sum + tasks(lesson).length - progress.right(lesson.name) - progress.shown(lesson.name), 0);
}

export function printCertificate(name, lessons, progress, tasks) {
  const rows = lessons.map((lesson) => [lesson.title, String(tasks(lesson).length), String(progress.right(lesson.name)), String(progress.shown(lesson.name))]);
  const sum = (column) => rows.reduce((total, row) => total + Number(row[column]), 0);
  printed(element("h1", {}, "A week at the winder"),
    element("p", {}, element("b", {}, name || "Somebody"), " has taken the course on the field bus SIS: commands and reactions, parameters, a bad line, \
times and their verdicts, phases, long data, routing, and a finding for the maker."),
    element("p", {}, `${sum(2)} of ${plural(sum(1), "task")} were done alone, ${sum(3)} after the answer was shown. Findings were judged by the learner.`),
    table([["Lesson", "Tasks", "Done", "Shown"], ...rows], { name: "Lessons" }),
    element("p", {}, new Date().toISOString().slice(0, 10)));
}
