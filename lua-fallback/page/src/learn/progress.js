// SPDX-License-Identifier: GPL-2.0-or-later
// Keeps which questions are answered, and what is typed: in the browser, where it allows that; else until the page is
// closed. A learner saves it as a file for a teacher.

const PLACE = "sistap-course";
const KIND = "sis-course-results"; // of a file

const object = (found) => (found && typeof found === "object" && !Array.isArray(found) ? found : {});

export class Progress {
  constructor() {
    try {
      this.storage = globalThis.localStorage;
      this.storage.setItem(`${PLACE}-try`, "1");
      this.storage.removeItem(`${PLACE}-try`);
    } catch {
      this.storage = null;
    }
    this.lessons = this.read(); // lesson: {answers: {question: "right" or "shown"}, typed: {field: text}}
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

  // How a question was answered: "right", or "shown" if its answer was opened before. What came first counts: returns it.
  answer(lesson, question, how) {
    if (!this.of(lesson).answers[question]) this.set(lesson, "answers", question, how);
    return this.of(lesson).answers[question];
  }

  type(lesson, field, text) {
    this.set(lesson, "typed", field, text);
  }

  right(lesson) {
    return this.counted(lesson, "right");
  }

  shown(lesson) {
    return this.counted(lesson, "shown");
  }

  counted(lesson, how) {
    return Object.values(this.of(lesson).answers).filter((one) => one === how).length;
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

// Reads a file of results: {name, when, right(lesson)}. Throws if it is none.
export function readResults(text) {
  let found;
  try {
    found = object(JSON.parse(text));
  } catch {
    found = {};
  }
  if (found.kind !== KIND) throw new Error("this is no file of results: learners save one with “Save my results”");
  const lessons = object(found.lessons);
  const counted = (lesson, how) => Object.values(object(object(lessons[lesson]).answers)).filter((one) => one === how).length;
  return { name: String(found.name), when: String(found.when), right: (lesson) => counted(lesson, "right"), shown: (lesson) => counted(lesson, "shown") };
}
