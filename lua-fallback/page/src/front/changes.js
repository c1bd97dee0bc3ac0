// SPDX-License-Identifier: GPL-2.0-or-later
// Who changed which parameter: what `sistap parameters --changes` finds in the capture that is open.

import { fromCsv } from "./csv.js";
import { button, element, plural, save, table } from "./dom.js";
import { fileName } from "./files.js";
import { callTap } from "./tap.js";

const OUT = ".changes.csv";
const HEAD = ["Time", "Master", "Station", "Parameter", "Name", "From", "To", "Packet"];
const PARAMETER = HEAD.indexOf("Parameter"), PACKET = HEAD.indexOf("Packet");
const MOST = 1000; // rows
const TIME = "2000-01-01 00:00:00.000".length;

// Returns {csv, changes}, a change by the names of sistap's columns. `options` are those of callTap.
export async function changed(capture, options) {
  const file = fileName(capture.bytesName);
  const { code, said, written } = await callTap("command",
    [["parameters", "--changes", "--csv", file, "-o", OUT], { [file]: capture.bytes }, [OUT]], options);
  if (code) throw new Error(said.trim());
  const [names, ...rows] = fromCsv(new TextDecoder().decode(written[OUT]));
  return { csv: written[OUT], changes: rows.map((row) => Object.fromEntries(row.map((text, place) => [names[place], text]))) };
}

export function changesView(capture, acts) {
  const body = element("div", {});
  const root = element("section", { className: "page", "aria-labelledby": "changes-title" },
    element("h1", { id: "changes-title" }, "Changes"),
    element("p", {}, "Each write that changed the value of a parameter: when, by whom, from what, to what."), body);
  let of = null; // the bytes that they are of
  root.enter = () => of === capture.bytes || acts.showing(async () => {
    const { bytes } = capture;
    const { csv, changes } = await capture.long("Looking for changes", (options) => changed(capture, options));
    of = bytes;
    const saving = button("Save all as CSV", () => save(`${capture.name}-changes.csv`, csv, "text/csv"));
    body.replaceChildren(...(changes.length ? [...draw(changes, acts), saving] : [element("p", {}, "No write changed a value.")]));
  });
  capture.addEventListener("opened", () => {
    of = null;
    body.replaceChildren();
  });
  return root;
}

const wholeName = ({ parameter, name, station }) => `${parameter}${name && ` ${name}`}, station ${station}`;

// Draws all of them, or those of one parameter: a master that writes its command value all the time hides the rest.
function draw(changes, acts) {
  const counts = new Map();
  for (const change of changes) counts.set(wholeName(change), (counts.get(wholeName(change)) ?? 0) + 1);
  const rare = [...counts].sort(([, one], [, other]) => one - other);
  const place = element("div", {});
  const show = () => {
    const wanted = changes.filter((change) => !select.value || wholeName(change) === select.value);
    const left = wanted.length > MOST ? ` The table has the first ${MOST}, the file all.` : "";
    place.replaceChildren(element("p", { role: "status" }, `${plural(wanted.length, "change")}.${left}`), tableOf(wanted.slice(0, MOST), acts));
  };
  const select = element("select", { id: "changed", onchange: show }, element("option", { value: "" }, "all parameters"),
    ...rare.map(([name, count]) => element("option", { value: name }, `${name} (${count})`)));
  show();
  return [element("p", { className: "form-line" }, element("label", { htmlFor: "changed" }, "Show"), select), place];
}

function tableOf(changes, { goTo, applyFilter }) {
  const rows = changes.map(({ time, master, station, device, parameter, name, from, to, packet }) =>
    [time.replace("T", " ").slice(0, TIME), master, device === station ? station : `${station}, device ${device}`, parameter, name,
      from || "unknown", to || "unknown", packet]);
  const cell = (text, place, row) => {
    const { parameter, station } = changes[row];
    const filter = `sis.parameter == "${parameter}"${/^\d+$/.test(station) ? ` && sis.station == ${station}` : ""}`;
    if (place === PARAMETER) return button(text, () => applyFilter(filter), { className: "link", title: filter });
    return place === PACKET ? button(text, () => goTo(Number(text)), { className: "link", "aria-label": `Packet ${text}` }) : text;
  };
  return table([HEAD, ...rows], { name: "Changes", numeric: [PACKET], cell });
}
