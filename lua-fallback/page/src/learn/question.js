// SPDX-License-Identifier: GPL-2.0-or-later
// A question: what is to be typed or chosen, a hint, and the answer.

import { element } from "../front/dom.js";
import { check } from "./answers.js";
import { ours } from "./ours.js";

const FORMS = {
  number: "a number", packets: "packet numbers, or none", hex: "bytes in hexadecimal", filter: "a display filter", text: "a word",
};

// `kept` is what was typed before, by the name of a field; `matched(filter)` says how many packets a filter leaves;
// `told` is called with "right" or "shown" and returns what counts, `typed` is called with a field and its text.
export function questionOf({ number, text, lead, hint, answer, asks }, { kept, matched, showing, told, typed }) {
  const fields = asks.map((ask, place) => askOf(ask, `ask-${number}-${place}`, kept, typed));
  const verdict = element("p", { className: "verdict", role: "status" });
  const shown = element("details", { className: "answer", ontoggle: () => shown.open && told("shown") },
    element("summary", {}, "Answer"), element("ul", {}, ...asks.map(acceptedOf)), ours("div", answer));

  async function judge() {
    const results = [];
    for (const { ask, value, say } of fields) {
      const result = await check(ask, value(), matched);
      say(result);
      results.push(result.right === true);
    }
    const right = results.every(Boolean), parts = results.filter(Boolean).length;
    verdict.className = `verdict ${right ? "right" : "wrong"}`;
    if (!right) {
      verdict.textContent = `${results.length > 1 ? `${parts} of ${results.length} right. ` : ""}Try again, or open the hint.`;
      return;
    }
    verdict.textContent = told("right") === "right" ? "Right. The answer below says why."
      : "Right. But the answer was opened before, so it counts as shown.";
    shown.open = true;
  }

  const form = element("form", { autocomplete: "off", onsubmit: (event) => {
    event.preventDefault();
    showing(judge);
  } }, ...fields.map(({ root }) => root), element("p", {}, element("button", { type: "submit" }, "Check")), verdict);
  return element("section", { className: "question", "aria-label": `Question ${number}`, "data-number": number },
    ours("h3", `${number}. ${text}`), ours("div", lead), form,
    element("details", { className: "hint" }, element("summary", {}, "Hint"), ours("div", hint)), shown);
}

function acceptedOf({ prompt, accepted }) {
  const item = ours("li", prompt);
  item.append(": ", ...accepted.flatMap((one, at) => [at ? " or " : "", element("code", {}, one)]));
  return item;
}

// A thing to be typed or chosen: {root, ask, value(), say(result)}.
function askOf(ask, id, kept, typed) {
  const said = element("span", { className: "said", id: `${id}-said` });
  const say = ({ right, say: words }) => {
    said.textContent = words;
    said.className = `said ${right === null ? "unread" : right ? "right" : "wrong"}`;
  };
  const note = ({ target }) => typed(id, target.value);
  return { ask, say, ...(ask.kind === "choice" ? chosen : written)(ask, id, kept[id] ?? "", note, said) };
}

function chosen({ prompt, choices }, id, kept, note, said) {
  const inputs = choices.map((value) => element("input", { type: "radio", name: id, value, checked: value === kept, onchange: note }));
  const labels = inputs.map((input) => element("label", {}, input, ` ${input.value} `));
  return { value: () => inputs.find(({ checked }) => checked)?.value ?? "",
    root: element("fieldset", { className: "ask" }, ours("legend", prompt), ...labels, said) };
}

function written({ prompt, kind, unit: asked, accepted }, id, kept, note, said) {
  const unit = asked || kind !== "number" ? asked : accepted[0].split(" ").slice(1).join(" ");
  const input = element("input", { type: "text", id, className: kind, value: kept, spellcheck: false, autocapitalize: "off",
    "aria-describedby": said.id, oninput: note });
  const label = ours("label", prompt, { htmlFor: id });
  label.append(" ", element("small", {}, `(${FORMS[kind]}${unit ? ` of ${unit}` : ""})`));
  return { value: () => input.value, root: element("p", { className: "ask" }, label, " ", input, " ", said) };
}
