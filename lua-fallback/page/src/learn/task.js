// SPDX-License-Identifier: GPL-2.0-or-later
// A task: what is to be typed, chosen, built or written, a hint, and its solution, which is in the page only when it is opened.

import { element } from "../front/dom.js";
import { check } from "./answers.js";
import { findingField } from "./finding.js";
import { ours } from "./ours.js";
import { telegramField } from "./workbench.js";

const FORMS = {
  number: "a number", packets: "packet numbers, or none", hex: "bytes in hexadecimal", filter: "a display filter", text: "a word",
};

// `kept` is what was typed before, by the name of a field; `matched(filter)` says how many packets a filter leaves;
// `told` is called with "right", "own" (the learner judged a finding) or "shown" and returns what counts; `typed` is called
// with a field and its text, `linked` with a text whose packets are to be one click away.
export function taskOf({ number, text, lead, hint, solution, blanks }, { kept, matched, showing, told, typed, linked }) {
  const begin = ours("div", lead);
  const fields = blanks.map((blank, place) => fieldOf(blank, `blank-${number}-${place}`, { kept, matched, typed, begin }));
  const verdict = element("p", { className: "verdict", role: "status" });
  const shown = element("details", { className: "answer", ontoggle: () => {
    if (!shown.open) return;
    if (shown.children.length === 1) {
      shown.append(element("ul", {}, ...blanks.filter(({ accepted }) => accepted.length).map(acceptedOf)), ours("div", solution));
      linked(shown);
    }
    if (!isRight) told("shown");
  } }, element("summary", {}, "Show the answer"));
  let isRight = false;

  async function judge() {
    const results = [];
    for (const { say, judged } of fields) {
      const result = await judged();
      say(result);
      results.push(result.right === true);
    }
    isRight = results.every(Boolean);
    verdict.className = `verdict ${isRight ? "right" : "wrong"}`;
    if (isRight) {
      const how = blanks.some(({ kind }) => kind === "finding") ? "own" : "right";
      verdict.textContent = told(how) === how ? "Right. The answer below says why."
        : "Right. But the answer was opened before, so it counts as shown.";
      shown.open = true;
    } else {
      const parts = results.filter(Boolean).length;
      verdict.textContent = `${results.length > 1 ? `${parts} of ${results.length} right. ` : ""}Try again${hint ? ", or open the hint" : ""}.`;
    }
  }

  const form = element("form", { autocomplete: "off", onsubmit: (event) => {
    event.preventDefault();
    showing(judge);
  } }, ...fields.map(({ root }) => root), element("p", {}, element("button", { type: "submit" }, "Check")), verdict);
  return element("section", { className: "task", "aria-label": `Task ${number}`, "data-number": number },
    ours("h3", `${number}. ${text}`), begin, form,
    ...(hint ? [element("details", { className: "hint" }, element("summary", {}, "Hint"), ours("div", hint))] : []), shown);
}

function acceptedOf({ prompt, accepted }) {
  const item = ours("li", prompt);
  item.append(": ", ...accepted.flatMap((one, at) => [at ? " or " : "", element("code", {}, one)]));
  return item;
}

const FIELDS = { choice: chosen, telegram: built, finding: found };

// A thing to be typed, chosen, built or written: {root, say(result), judged()}.
function fieldOf(blank, id, { kept, matched, typed, begin }) {
  const said = element("span", { className: "said", id: `${id}-said`, role: "status" });
  const say = ({ right, say: words }) => {
    said.textContent = words;
    said.className = `said ${right === null ? "unread" : right ? "right" : "wrong"}`;
  };
  const make = FIELDS[blank.kind] ?? written;
  return { say, ...make(blank, { id, text: kept[id] ?? "", note: (text) => typed(id, text), said, matched, begin }) };
}

function chosen(blank, { id, text, note, said, matched }) {
  const inputs = blank.choices.map((value) =>
    element("input", { type: "radio", name: id, value, checked: value === text, onchange: () => note(value) }));
  const labels = inputs.map((input) => element("label", {}, input, ` ${input.value} `));
  return { judged: () => check(blank, inputs.find(({ checked }) => checked)?.value ?? "", matched),
    root: element("fieldset", { className: "blank" }, ours("legend", blank.prompt), ...labels, said) };
}

function written(blank, { id, text, note, said, matched }) {
  const { kind, unit } = blank;
  const input = element("input", { type: "text", id, className: `as-${kind}`, value: text, spellcheck: false, autocapitalize: "off",
    "aria-describedby": said.id, oninput: () => note(input.value) });
  const label = labelOf(blank, id);
  label.append(" ", element("small", {}, `(${FORMS[kind]}${unit ? ` of ${unit}` : ""})`));
  return { judged: () => check(blank, input.value, matched), root: element("p", { className: "blank" }, label, " ", input, " ", said) };
}

// A repair begins with the first bytes that the task shows.
function built(blank, { id, text, note, said, begin }) {
  const given = begin.querySelector("pre")?.textContent.split("\n")[0] ?? "";
  const { root, judged } = telegramField(blank, { id, text: text || given, note });
  return { judged, root: element("div", { className: "blank" }, labelOf(blank, id), root, said) };
}

function found(blank, { id, text, note, said }) {
  const { root, judged } = findingField(blank, { id, text, note });
  return { judged, root: element("div", { className: "blank" }, labelOf(blank, id), root, said) };
}

const labelOf = ({ prompt }, id) => ours("label", prompt, { htmlFor: id });
