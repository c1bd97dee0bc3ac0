// SPDX-License-Identifier: GPL-2.0-or-later
// Who changed which parameter: what `sistap parameters --changes` finds in the capture that is open, the newest first.

import { ofParameter } from "./applying.js";
import { fromCsv } from "./csv.js";
import { button, element, plural, save } from "./dom.js";
import { fileName } from "./files.js";
import { LongTable } from "./longtable.js";
import { callTap } from "./tap.js";

const OUT = ".changes.csv";
const VALUE = 32; // characters of a value; all of them are in the title
const COLUMNS = [{ title: "Time" }, { title: "Master" }, { title: "Station" }, { title: "Parameter" }, { title: "Name", most: 40 },
  { title: "From", most: VALUE }, { title: "To", most: VALUE }, { title: "Packet", isRight: true }];
const [PARAMETER, PACKET] = ["Parameter", "Packet"].map((wanted) => COLUMNS.findIndex(({ title }) => title === wanted));
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
    element("p", {}, "Each write that changed the value of a parameter: when, by whom, from what, to what. The newest is first."), body);
  let of = null; // the bytes that they are of
  root.enter = () => of === capture.bytes || acts.showing(async () => {
    const { bytes } = capture;
    const { csv, changes } = await capture.long("Looking for changes", (options) => changed(capture, options));
    of = bytes;
    const saving = button("Save all as CSV", () => save(`${capture.name}-changes.csv`, csv, "text/csv"));
    body.replaceChildren(...(changes.length ? draw(changes.reverse(), acts, saving) : [element("p", {}, "No write changed a value.")]));
  });
  capture.addEventListener("opened", () => {
    of = null;
    body.replaceChildren();
  });
  return root;
}

const wholeName = ({ parameter, name, station }) => `${parameter}${name && ` ${name}`}, station ${station}`;
const timeOf = ({ time }) => time.replace("T", " ").slice(0, TIME);
const stationOf = ({ station, device }) => (device === station ? station : `${station}, device ${device}`);
const cut = (text) => (text.length > VALUE ? `${text.slice(0, VALUE)}...` : text || "unknown");

const rowOf = (change) => [timeOf(change), change.master, stationOf(change), change.parameter, change.name,
  change.from || "unknown", change.to || "unknown", change.packet];

// What a technician asks first.
function last(change, { goTo }) {
  const { master, parameter, name, from, to, packet } = change;
  const words = `${timeOf(change)}, master ${master}, station ${stationOf(change)}, ${parameter}${name && ` ${name}`} from ${cut(from)} to ${cut(to)}, packet ${packet}`;
  return element("p", { className: "last-write" }, element("b", {}, "Last write:"), " ", button(words, () => goTo(Number(packet)), { className: "link" }));
}

// Draws all of them, or those of one parameter: a master that writes its command value all the time hides the rest.
function draw(changes, acts, saving) {
  const counts = new Map();
  for (const change of changes) counts.set(wholeName(change), (counts.get(wholeName(change)) ?? 0) + 1);
  const rare = [...counts].sort(([, one], [, other]) => one - other);
  const said = element("span", { role: "status" });
  let wanted = changes;
  const table = new LongTable({ columns: COLUMNS, name: "Changes", cell: (text, column, place) => cell(text, column, wanted[place], acts) });
  const show = () => {
    wanted = changes.filter((change) => !select.value || wholeName(change) === select.value);
    said.textContent = plural(wanted.length, "change");
    table.show(wanted.map(rowOf));
  };
  const select = element("select", { id: "changed", onchange: show }, element("option", { value: "" }, "all parameters"),
    ...rare.map(([name, count]) => element("option", { value: name }, `${name} (${count})`)));
  show();
  return [last(changes[0], acts), element("p", { className: "form-line" }, element("label", { htmlFor: "changed" }, "Show"), select, said, saving), table.root];
}

function cell(text, column, { parameter, station }, { goTo, applyFilter }) {
  const filter = ofParameter(parameter, station);
  if (column === PARAMETER) return button(text, () => applyFilter(filter), { className: "link", title: filter });
  return column === PACKET ? button(text, () => goTo(Number(text)), { className: "link", "aria-label": `Packet ${text}` }) : text;
}
