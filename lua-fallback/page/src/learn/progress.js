// SPDX-License-Identifier: GPL-2.0-or-later
// Keeps which tasks are done, and what is typed: in the browser, where it allows that; else until the page is
// closed. A learner saves it as a file for a teacher.

const PLACE = "sistap-course";
const KIND = "sis-course-results"; // of a file

const object = (found) => (found && typeof found === "object" && !Array.isArray(found) ? found : {});

const counted = ({ answers }, ...hows) => Object.values(object(answers)).filter((one) => hows.includes(one)).length;

export class Progress {
  constructor() {
    try {
      this.storage = globalThis.localStorage;
      this.storage.setItem(`${PLACE}-try`, "1");
      this.storage.removeItem(`${PLACE}-try`);
    } catch {
      this.storage = null;
    }
    this.lessons = this.read(); // lesson: {answers: {task: "right", "own" or "shown"}, typed: {field: text}}
  }

  read() {
    try {
      return object(JSON.parse(this.storage?.getItem(PLACE) ?? "{}"));
    } catch {
      return {}; // not ours, or damaged: begin again
    }
  }

  get isKept() {
    return this.storage !== null;
  }

  of(lesson) {
    const { answers, typed } = object(this.lessons[lesson]);
    return { answers: object(answers), typed: object(typed) };
  }

  set(lesson, kind, name, value) {
    const { answers, typed } = this.of(lesson);
    this.lessons[lesson] = { answers, typed, [kind]: { ...this.of(lesson)[kind], [name]: value } };
    try {
      this.storage?.setItem(PLACE, JSON.stringify(this.lessons));
    } catch {
      this.storage = null;
    }
  }

  // How a task was done: "right", "own" of a finding that the learner judged, or "shown" if its answer was opened before.
  // What came first counts: returns it.
  answer(lesson, task, how) {
    if (!this.of(lesson).answers[task]) this.set(lesson, "answers", task, how);
    return this.of(lesson).answers[task];
  }

  type(lesson, field, text) {
    this.set(lesson, "typed", field, text);
  }

  right(lesson) {
    return counted(this.of(lesson), "right", "own");
  }

  shown(lesson) {
    return counted(this.of(lesson), "shown");
  }

  // Of all lessons.
  get answers() {
    return Object.keys(this.lessons).reduce((sum, lesson) => sum + Object.keys(this.of(lesson).answers).length, 0);
  }

  forget() {
    this.lessons = {};
    this.storage?.removeItem(PLACE);
  }

  // What a learner hands to a teacher.
  results(name) {
    return JSON.stringify({ kind: KIND, name, when: new Date().toISOString(), lessons: this.lessons }, null, 1);
  }
}

// Reads a file of results: {name, when, right(lesson), shown(lesson), typed(lesson)}. Throws if it is none.
export function readResults(text) {
  let found;
  try {
    found = object(JSON.parse(text));
  } catch {
    found = {};
  }
  if (found.kind !== KIND) throw new Error("this is no file of results: learners save one with “Save my results”");
  const lessons = object(found.lessons);
  const of = (lesson) => object(lessons[lesson]);
  return { name: String(found.name), when: String(found.when), typed: (lesson) => object(of(lesson).typed),
    right: (lesson) => counted(of(lesson), "right", "own"), shown: (lesson) => counted(of(lesson), "shown") };
}
