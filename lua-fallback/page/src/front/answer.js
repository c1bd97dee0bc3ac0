// SPDX-License-Identifier: GPL-2.0-or-later
// What happened, in short, as `sistap report` says it: a bar above the packets, and a view with all that it found.

import { Stopped } from "../protocol.js";
import { ofParameter } from "./applying.js";
import { button, element, plural, table } from "./dom.js";
import { judge } from "./judging.js";

const AT_ONCE = 5000; // packets of a capture that is judged without being asked: some seconds
const UNUSUAL = 5; // a slowest answer that takes so many times what half of the answers take is worth a look

const ms = (seconds) => `${(seconds * 1000).toFixed(seconds < 0.1 ? 1 : 0)} ms`;

export class Answer {
  constructor(capture, { applyFilter, goTo, showing, tellLimits }) {
    this.capture = capture;
    this.applyFilter = applyFilter;
    this.goTo = goTo;
    this.tellLimits = tellLimits;
    this.bar = element("div", { className: "answer-bar", role: "status" });
    this.body = element("div", {});
    this.root = element("section", { className: "page", "aria-labelledby": "answer-title" },
      element("h1", { id: "answer-title" }, "What happened"), this.body);
    this.root.enter = () => this.found || showing(() => capture.long("Looking for faults", (options) => judge(capture, options)));
    capture.addEventListener("opened", () => this.begin());
    capture.addEventListener("grown", () => this.forget());
    capture.addEventListener("judged", () => this.show());
  }

  get found() {
    return this.capture.found;
  }

  forget() {
    this.bar.replaceChildren();
    this.body.replaceChildren();
  }

  // Judges what was opened; not beside a lesson, whose reader does that.
  begin() {
    this.forget();
    if (location.hash.startsWith("#learn")) return;
    if (this.capture.packets <= AT_ONCE) this.lookAside();
    else this.offer();
  }

  offer() {
    this.bar.className = "answer-bar";
    this.bar.replaceChildren(button("What happened here?", () => (location.hash = "#answer")));
  }

  // Looks while a person already reads. Whatever else needs sistap ends it.
  async lookAside() {
    this.bar.className = "answer-bar";
    this.bar.replaceChildren("Looking for faults ...");
    try {
      await judge(this.capture, { givesWay: true });
    } catch (error) {
      if (!(error instanceof Stopped)) this.bar.replaceChildren(error.message);
      else if (!this.found) this.offer();
    }
  }

  show() {
    const { answer: [first, ...lines] } = this.found;
    this.bar.className = `answer-bar ${verdict(this.found)}`;
    this.bar.replaceChildren(element("b", {}, first), " ", ...this.slowest(), ...this.silent(), ...this.unjudged(), " ", element("a", { href: "#answer" }, "What happened"));
    this.body.replaceChildren(element("ul", { className: "answer" }, ...[first, ...lines].map((line) => element("li", {}, line))),
      ...this.asked(), ...this.stations(), ...this.episodes(), ...this.parameters());
  }

  // What cannot be judged, because neither the bus nor a person has told the limit.
  unjudged() {
    const { not_judged: words } = this.found;
    return words.length ? [` Not judged: ${words.join(", ")}. `, button("Limits", this.tellLimits)] : [];
  }

  asked() {
    if (!this.found.not_judged.length) return [];
    return [element("p", {}, "If you know these limits, tell them: ", button("Limits", this.tellLimits))];
  }

  // The stations that answer, the slowest one first.
  get answering() {
    return this.found.stations.filter(({ reaction_times: { count }, not_answered: none }) => count > 0 || none > 0)
      .sort((one, other) => (other.reaction_times.longest_s ?? 0) - (one.reaction_times.longest_s ?? 0));
  }

  slowest() {
    const [first] = this.answering;
    if (!first?.reaction_times.count) return [];
    const { station, reaction_times: { half_within_s: half, longest_s: longest } } = first;
    return ["Slowest to answer: ", this.toLongest(station, longest, `station ${station}, up to ${ms(longest)}`), ` (half of its answers: ${ms(half)}).`,
      longest > UNUSUAL * half ? " That is unusual: look at it." : ""];
  }

  silent() {
    const found = this.answering.filter(({ not_answered: count }) => count > 0).map(({ station, not_answered: count }) => `station ${station}, ${plural(count, "time")}`);
    return found.length ? [` No answer: ${found.join("; ")}.`] : [];
  }

  // Leads to the answers of a station that took longest.
  toLongest(station, seconds, words) {
    const filter = `sis.talker == ${station} && sis.reaction_time >= ${(Math.floor(seconds * 1e6) / 1e6).toFixed(6)}`;
    return button(words, () => this.applyFilter(filter), { className: "link", title: filter });
  }

  stations() {
    const found = this.answering;
    const rows = found.map(({ station, reaction_times: { count, half_within_s: half, longest_s: longest }, ...counts }) =>
      [String(station), String(count), count ? ms(half) : "", count ? ms(longest) : "",
        String(counts.not_answered), String(counts.sent_again), String(counts.reactions_with_error)]);
    const head = ["Station", "Answers", "Half of them within", "Slowest", "Not answered", "Sent again", "With an error"];
    const cell = (text, place, row) => (place === 3 && text ? this.toLongest(found[row].station, found[row].reaction_times.longest_s, text) : text);
    return [element("h2", {}, "Who answers, and how fast"),
      rows.length ? table([head, ...rows], { name: "Stations", numeric: [1, 2, 3, 4, 5, 6], cell }) : element("p", {}, "No answer was found.")];
  }

  episodes() {
    const { episodes } = this.found;
    const words = ({ count, packets: { length } }) => (length < count ? `${length} of ${count} packets` : plural(length, "packet"));
    const rows = episodes.map((one) => [new Date(one.from).toLocaleString("sv-SE"), one.severity, one.text, words(one)]);
    const show = (packets) => () => this.applyFilter(`frame.number in {${packets.join(", ")}}`);
    const cell = (text, place, row) => (place === 3 && episodes[row].packets.length ? button(text, show(episodes[row].packets), { className: "link" }) : text);
    return [element("h2", {}, "What was found"),
      rows.length ? table([["From", "Severity", "What", "Packets"], ...rows], { name: "Episodes", cell }) : element("p", {}, "Nothing.")];
  }

  parameters() {
    const { parameters } = this.found;
    if (!parameters.length) return [];
    const rows = parameters.map(({ ident, name, station, reads, writes, errors, first, last, written_in: written }) =>
      [ident, name, station, ...[reads, writes, errors].map(String), first, last, written ? String(written) : ""]);
    const cell = (text, place, row) => {
      if (place === 0) return this.toParameter(parameters[row]);
      return place === 8 && text ? button(text, () => this.goTo(Number(text)), { className: "link", "aria-label": `Packet ${text}` }) : text;
    };
    return [element("h2", {}, "What was read and written"), table([PARAMETERS, ...rows], { name: "Parameters", numeric: [3, 4, 5, 8], cell })];
  }

  toParameter({ ident, station }) {
    const filter = ofParameter(ident, station);
    return button(ident, () => this.applyFilter(filter), { className: "link", title: filter });
  }
}

const PARAMETERS = ["Parameter", "Name", "Station", "Reads", "Writes", "Errors", "First", "Last", "Written in"];

// The colour of the bar: plain where something is to be looked at, or was not judged.
function verdict({ ok, look, not_judged: unjudged, telegrams }) {
  if (!telegrams.all) return "";
  if (!ok) return "bad";
  return look || unjudged.length ? "" : "good";
}
