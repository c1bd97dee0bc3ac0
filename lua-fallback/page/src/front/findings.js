// SPDX-License-Identifier: GPL-2.0-or-later
// The expert items of a capture, the same ones together.

import { button, element, plural } from "./dom.js";

const SEVERITIES = ["Error", "Warning", "Note", "Chat", "Comment"];
const SHOWN = 40; // packets of a group that are shown at once

// Items whose texts differ in numbers only are the same.
const kindOf = ([severity, group, , text]) => [severity, group, text.replace(/(0x[0-9a-f]+|\d+([.]\d+)?)/gi, "#")].join("\n");

function grouped(experts) {
  const groups = new Map();
  for (const expert of experts) {
    const [severity, group, number, text] = expert;
    const kind = kindOf(expert);
    if (!groups.has(kind)) groups.set(kind, { severity, group, texts: new Set(), packets: [] });
    const found = groups.get(kind);
    found.texts.add(text);
    found.packets.push({ number: Number(number), text });
  }
  const rank = ({ severity }) => SEVERITIES.indexOf(severity);
  return [...groups.values()].sort((one, other) => rank(one) - rank(other) || other.packets.length - one.packets.length);
}

export function findingsView(capture, { goTo, showing }) {
  const body = element("div", {});
  const root = element("section", { className: "page", "aria-labelledby": "findings-title" },
    element("h1", { id: "findings-title" }, "Findings"),
    element("p", {}, "What Wireshark marks in the packets: errors, warnings and notes."), body);
  root.enter = () => showing(async () => {
    const { experts } = await capture.figures();
    body.replaceChildren(...draw(grouped(experts), goTo));
  });
  capture.addEventListener("opened", () => body.replaceChildren());
  return root;
}

function draw(groups, goTo) {
  if (!groups.length) return [element("p", {}, "Nothing is marked.")];
  return groups.map(({ severity, group, texts, packets }) => element("details", { className: `finding severity-${severity.toLowerCase()}` },
    element("summary", {}, element("b", {}, severity), " ", element("small", {}, group), " ", [...texts][0],
      texts.size > 1 ? " (and alike)" : "", " ", element("span", { className: "count" }, plural(packets.length, "time"))),
    ...listed(packets, goTo)));
}

// The first packets of a group, and a button that shows more of them.
function listed(packets, goTo) {
  const list = element("ul", {});
  const more = button("", () => show());
  const show = () => {
    const next = packets.slice(list.childElementCount, list.childElementCount + SHOWN);
    list.append(...next.map(({ number, text }) => element("li", {}, button(`Packet ${number}`, () => goTo(number), { className: "link" }), " ", text)));
    const left = packets.length - list.childElementCount;
    more.hidden = left === 0;
    more.textContent = `Show ${Math.min(left, SHOWN)} of ${left.toLocaleString("en")} more`;
  };
  show();
  return [list, more];
}
