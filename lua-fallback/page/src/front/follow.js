// SPDX-License-Identifier: GPL-2.0-or-later
// All telegrams of two stations in turn, with their bytes.

import { button, element } from "./dom.js";
import { firstOf } from "./items.js";

const TOGETHER = 100; // telegrams that are fetched at once
const PROTOCOL = "sis";

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
  root.begin = (stream) => showing(async () => {
    const filter = `sis.stream == ${stream}`;
    body.replaceChildren();
    let skip = 0;
    const viewer = await capture.viewer;
    const more = async () => {
      const { matched, rows } = await viewer.call("rows", [filter, skip, TOGETHER]);
      for (const row of rows) body.append(await entry(viewer, row, goTo));
      skip += rows.length;
      title.textContent = `Follow: ${matched} telegrams of one pair of stations`;
      bar.replaceChildren(button("Show only these packets", () => applyFilter(filter)), " ",
        ...(skip < matched ? [button(`Show ${Math.min(TOGETHER, matched - skip)} more`, more)] : []));
    };
    await more();
  });
  return root;
}

async function entry(viewer, { number, cells }, goTo) {
  const { tree, sources } = await viewer.call("packet", [number]);
  const telegrams = tree.filter(({ filter }) => filter === PROTOCOL);
  const bytes = telegrams.map(({ source, start, length }) => Array.from(sources[source].bytes.subarray(start, start + length),
    (byte) => byte.toString(16).padStart(2, "0")).join(" ")).join("\n");
  const words = cells.at(-1);
  return element("div", { role: "listitem", className: / Reaction /.test(words) ? "reaction" : "command" },
    button(`${number}`, () => goTo(number), { className: "link", "aria-label": `Packet ${number}` }), element("span", {}, words), element("code", {}, bytes));
}
