// SPDX-License-Identifier: GPL-2.0-or-later
// Keeps which questions are answered: in the browser, where it allows that; else until the page is closed.
// Some browsers keep a store for each file, so a lesson also tells the index in the link that leads there.

const PLACE = "sistap-course";
let kept = {}; // lesson: {question: "right" or "shown"}
let storage = null;

try {
  storage = window.localStorage;
  storage.setItem(`${PLACE}-try`, "1");
  storage.removeItem(`${PLACE}-try`);
} catch {
  storage = null;
}

function readProgress() {
  let found = null;
  try {
    found = JSON.parse(storage ? storage.getItem(PLACE) : "{}");
  } catch {
    found = null; // not ours, or damaged: begin again
  }
  kept = found && typeof found === "object" && !Array.isArray(found) ? found : {};
}

function keepProgress() {
  try {
    if (storage) storage.setItem(PLACE, JSON.stringify(kept));
  } catch {
    storage = null;
  }
}

function answered(lesson) {
  return kept[lesson] && typeof kept[lesson] === "object" ? kept[lesson] : {};
}

function note(lesson, question, how) {
  const questions = answered(lesson);
  if (questions[question] === "right") return;
  kept[lesson] = { ...questions, [question]: how };
  keepProgress();
}

const rightOnes = (lesson) => Object.values(answered(lesson)).filter((how) => how === "right").length;
const NOT_KEPT = "This browser does not let the page keep your progress.";

readProgress();
