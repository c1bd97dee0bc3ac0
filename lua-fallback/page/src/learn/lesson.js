// SPDX-License-Identifier: GPL-2.0-or-later
// A lesson beside its packets: its sections with their tasks, and what can be tried.

import { button, element, plural } from "../front/dom.js";
import { busOf, fileOf } from "./bus.js";
import { explain } from "./explained.js";
import { gateOf } from "./gate.js";
import { linkText } from "./links.js";
import { ours } from "./ours.js";
import { printLesson } from "./print.js";
import { taskOf } from "./task.js";
import { timeline } from "./timeline.js";
import { workbench } from "./workbench.js";

const MOVING = { "04-bad-line": 6, "06-timing": 9 }; // lessons with a timeline before their tasks, and its packet
const DONE = ["right", "own"];

export class Lesson {
  constructor(lesson, { root, lessons, capture, packetsView, progress, showing, applyFilter }) {
    this.lesson = lesson;
    this.root = root;
    this.lessons = lessons;
    this.capture = capture;
    this.packetsView = packetsView;
    this.progress = progress;
    this.showing = showing;
    this.applyFilter = applyFilter;
    this.state = element("p", { className: "lesson-state", role: "status" });
    this.gate = gateOf(lesson, progress, { changed: () => this.tell(), kept: packetsView });
  }

  async open() {
    const { lesson, capture, showing, gate } = this;
    const text = element("article", { className: "lesson-text" }, this.navigation(), ours("h1", lesson.title), this.state,
      ...busOf(lesson, capture, showing), ours("div", lesson.text), ...lesson.sections.map((section) => this.section(section)),
      gate.guard(this.tools()), ours("div", lesson.end));
    this.root.replaceChildren(element("div", { className: "lesson" }, text,
      element("aside", { "aria-label": "Packets of the lesson" }, gate.root, this.packetsView)));
    this.tell();
    await this.openPart(this.whole);
  }

  // The capture of the lesson, and that of its section Prove: there nothing is judged.
  get whole() {
    return { name: fileOf(this.lesson), encoded: this.lesson.capture, isRaw: false };
  }

  get raw() {
    return { name: `${this.lesson.name}-proof.pcapng`, encoded: this.lesson.proof, isRaw: true };
  }

  link(text, part) {
    const opened = () => this.capture.name !== part.name && this.openPart(part);
    linkText(text, { capture: this.capture, showing: this.showing, applyFilter: this.applyFilter, opened });
  }

  async openPart({ name, encoded, isRaw }) {
    await this.capture.live?.stop();
    this.packetsView.classList.toggle("raw", isRaw);
    const { preferences } = this.lesson;
    await this.capture.open(name, Uint8Array.from(atob(encoded), (letter) => letter.charCodeAt(0)), { preferences });
  }

  // A heading, its words and its tasks; before a prediction of times what can be tried.
  section({ title, text, tasks }) {
    const { name, proof } = this.lesson;
    const isProof = title === "Prove" && proof;
    const part = isProof ? this.raw : this.whole;
    const made = element("section", {}, ours("h2", title, { id: title.toLowerCase().replace(/ /g, "-") }), ours("div", text),
      ...(isProof ? [button("Open its raw capture", () => this.showing(() => this.openPart(part)))] : []),
      ...(title === "Predict" && name in MOVING ? [this.moving()] : []),
      ...tasks.map((task) => this.task(task, part)));
    explain(made);
    this.link(made, part);
    return made;
  }

  task(task, part) {
    const { capture, progress, showing, lesson: { name } } = this;
    const matched = async (filter) => {
      if (capture.name !== part.name) throw new Error(`Open ${part.name} first.`);
      return (await (await capture.viewer).call("rows", [filter, 0, 1])).matched;
    };
    return taskOf(task, {
      kept: progress.of(name).typed, matched, showing,
      typed: (field, text) => progress.type(name, field, text),
      linked: (text) => this.link(text, part),
      told: (how) => {
        const counts = progress.answer(name, task.number, how);
        this.tell();
        return counts;
      },
    });
  }

  tell() {
    const { name, sections } = this.lesson;
    const { answers } = this.progress.of(name);
    const count = sections.reduce((sum, { tasks }) => sum + tasks.length, 0), opened = this.progress.shown(name);
    this.state.textContent = `${this.progress.right(name)} of ${plural(count, "task")} done${opened ? `, ${plural(opened, "answer")} shown` : ""}.`;
    for (const section of this.root.querySelectorAll(".task")) section.classList.toggle("done", DONE.includes(answers[section.dataset.number]));
    this.gate.tell();
  }

  navigation() {
    const { lesson, lessons, capture } = this;
    const place = lessons.indexOf(lesson);
    const links = [["", "Course"], ["/glossary", "Glossary"]];
    for (const [other, words] of [[lessons[place - 1], "Previous"], [lessons[place + 1], "Next"]]) if (other) links.push([`/${other.name}`, words]);
    return element("p", { className: "lesson-links" }, ...links.flatMap(([to, words]) => [element("a", { href: `#learn${to}` }, words), " "]),
      button("Print", () => this.showing(() => printLesson(lesson, capture))));
  }

  // What can be tried with the packets.
  tools() {
    return element("div", {}, element("h2", {}, "Try it"), ...(this.lesson.name in MOVING ? [] : [this.moving()]),
      workbench(() => this.capture.packet));
  }

  // A timeline. That of a lesson on times opens with its packet, as soon as the lesson has its packets.
  moving() {
    const { capture, lesson } = this;
    const moving = timeline(() => ({ bytes: capture.bytes, number: capture.number, packet: capture.packet }), lesson.preferences);
    const number = MOVING[lesson.name];
    const begin = () => {
      if (capture.name !== fileOf(lesson)) return;
      if (capture.number === number) {
        capture.removeEventListener("selected", begin);
        moving.open = true;
      } else {
        capture.goTo(number);
      }
    };
    if (number) capture.addEventListener("selected", begin);
    return moving;
  }
}
