// SPDX-License-Identifier: GPL-2.0-or-later
// All telegrams of two stations in turn, with their bytes.

import { button, element } from "./dom.js";
import { asHex, firstOf } from "./items.js";

const TOGETHER = 100; // telegrams that are fetched at once
const PROTOCOL = "sis";
const WORDS = "Following";
const KIND = / (Command|Reaction) /; // in the column that says what the packet is

// The number of the pair of stations that a packet belongs to; undefined without one.
export function streamOf(packet) {
  const found = firstOf(packet?.tree ?? [], "sis.stream")?.filter.match(/\d+$/);
  return found ? Number(found[0]) : undefined;
}

export function followView(capture, { goTo, applyFilter, showing }) {
  const body = element("div", { className: "follow", role: "list" });
  const title = element("h1", { id: "follow-title" }, "Follow");
  const bar = element("p", {});
  const root = element("section", { className: "page", "aria-labelledby": "follow-title" }, title, bar, body);
  let following = null; // what is followed now; the next one ends it
  root.begin = (stream) => {
    const mine = { filter: `sis.stream == ${stream}`, shown: 0 };
    following = mine;
    body.replaceChildren();
    bar.replaceChildren();
    title.textContent = "Follow";

    const more = () => showing(async () => {
      const { matched, rows } = await capture.ask(WORDS, "rows", [mine.filter, mine.shown, TOGETHER], capture);
      const end = mine.shown + rows.length;
      try {
        await capture.long(WORDS, (options) => add(rows, options));
      } finally {
        if (following === mine) say(matched, end);
      }
    });

    // Adds rows, until a person cancels it.
    async function add(rows, { signal, progress }) {
      const viewer = await capture.viewer, before = mine.shown;
      for (const row of rows) {
        const made = await entry(viewer, row, goTo);
        if (signal.aborted || following !== mine) return;
        body.append(made);
        mine.shown++;
        progress((mine.shown - before) / rows.length);
      }
    }

    function say(matched, end) {
      const left = matched - mine.shown;
      title.textContent = `Follow: ${matched} telegrams of one pair of stations`;
      bar.replaceChildren(button("Show only these packets", () => applyFilter(mine.filter)), " ",
        ...(mine.shown < end ? [`Cancelled after ${mine.shown}. `] : []),
        ...(left > 0 ? [button(`Show ${Math.min(TOGETHER, left)} more`, more)] : []));
    }

    return more();
  };
  return root;
}

async function entry(viewer, { number, cells }, goTo) {
  const { tree, sources } = await viewer.call("packet", [number]);
  const telegrams = tree.filter(({ filter }) => filter === PROTOCOL);
  const bytes = telegrams.map(({ source, start, length }) => asHex(sources[source].bytes.subarray(start, start + length))).join("\n");
  const words = cells.find((cell) => KIND.test(cell)) ?? "";
  return element("div", { role: "listitem", className: / Reaction /.test(words) ? "reaction" : "command" },
    button(`${number}`, () => goTo(number), { className: "link", "aria-label": `Packet ${number}` }), element("span", {}, words), element("code", {}, bytes));
}
