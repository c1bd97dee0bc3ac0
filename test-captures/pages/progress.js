// SPDX-License-Identifier: GPL-2.0-or-later
// Keeps which questions are answered, and what is typed: in the browser, where it allows that; else until the page
// is closed.
// Some browsers keep a store for each file, so a lesson also tells the index in the link that leads there.

const PLACE = "sistap-course";
const TYPED = `${PLACE}-typed`;
let kept = {}; // lesson: {question: "right" or "shown"}
let typed = {}; // lesson: {field: text}
let storage = null;

try {
  storage = window.localStorage;
  storage.setItem(`${PLACE}-try`, "1");
  storage.removeItem(`${PLACE}-try`);
} catch {
  storage = null;
}

function stored(place) {
  try {
    return object(JSON.parse(storage ? storage.getItem(place) : "{}"));
  } catch {
    return {}; // not ours, or damaged: begin again
  }
}

const object = (found) => (found && typeof found === "object" && !Array.isArray(found) ? found : {});

function keep() {
  try {
    if (!storage) return;
    storage.setItem(PLACE, JSON.stringify(kept));
    storage.setItem(TYPED, JSON.stringify(typed));
  } catch {
    storage = null;
  }
}

function forget() {
  kept = {};
  typed = {};
  keep();
}

const answered = (lesson) => object(kept[lesson]);
const typedIn = (lesson) => object(typed[lesson]);

function noteTyped(lesson, field, text) {
  typed[lesson] = { ...typedIn(lesson), [field]: text };
  keep();
}

function note(lesson, question, how) {
  const questions = answered(lesson);
  if (questions[question] === "right") return;
  kept[lesson] = { ...questions, [question]: how };
  keep();
}

const rightOnes = (lesson) => Object.values(answered(lesson)).filter((how) => how === "right").length;
const NOT_KEPT = "This browser does not let the page keep your progress.";

kept = stored(PLACE);
typed = stored(TYPED);
