// SPDX-License-Identifier: GPL-2.0-or-later
// Small windows: the limits to judge by, what an imported file does not say, and what the page consists of.

import { USUAL } from "../dissect/dissector.js";
import { button, element, table } from "./dom.js";
import { partText } from "./parts.js";

const field = (id, words, input) => element("p", { className: "field-line" }, element("label", { htmlFor: id }, words), input);
const number = (id, value) => element("input", { type: "number", id, min: 0, max: 60000, step: 1, value });

// Asks with a form; `done` gets what was typed, by id.
function ask(title, explanation, fields, action, done) {
  const form = element("form", { method: "dialog" }, element("h2", {}, title), explanation && element("p", {}, explanation), ...fields,
    element("p", {}, element("button", { type: "submit" }, action), " ", button("Cancel", () => dialog.close(), { autofocus: fields.length === 0 })));
  const dialog = element("dialog", { "aria-label": title, onclose: () => dialog.remove() }, form);
  form.addEventListener("submit", () => done(Object.fromEntries([...form.elements].filter(({ id }) => id).map(({ id, value }) => [id, value.trim()]))));
  document.body.append(dialog);
  dialog.showModal();
}

// Asks before something is gone.
export function askForget(what, done) {
  ask("Forget my progress?", `This deletes ${what} from this browser, and all that you have typed in the lessons. If a teacher wants your results, save them first.`,
    [], "Forget", done);
}

export function askLimits(capture, done) {
  const now = { ...USUAL, ...capture.preferences };
  const edition = element("select", { id: "edition" }, ...["IF02", "ECODRIVE03"].map((name) =>
    element("option", { value: name, selected: now["sis.edition"] === name }, name)));
  ask("Limits", "Usually the bus has told its limits in the capture. If not, say them here. 0 means: as the bus was told.", [
    field("tza", "TzA: longest interval in a telegram, in ms", number("tza", now["sis.tza_ms"])),
    field("trs", "TrS: longest reaction time, in ms", number("trs", now["sis.trs_ms"])),
    field("edition", "Edition of the telegram header", edition),
  ], "Use them", (typed) => done({ "sis.tza_ms": typed.tza || "0", "sis.trs_ms": typed.trs || "0", "sis.edition": typed.edition }));
}

// `told` is what was said before, by option.
export function askImport(message, told, done) {
  const text = (id, example) => element("input", { type: "text", id, placeholder: example, value: told[id] ?? "" });
  ask("What the file does not say", message, [
    field("baud", "Rate in Bd", text("baud", "9600")),
    field("format", "Format of a character", text("format", "8E1")),
    field("samplerate", "Sample rate in Hz, of a logic analyser", text("samplerate", "1000000")),
    field("device", "Adapter, or channels of a logic analyser", text("device", "1.5 or D0,D1")),
  ], "Try again", (typed) => done(Object.fromEntries(Object.entries(typed).filter(([, value]) => value))));
}

export function askPattern(message, done) {
  ask("No telegram was found", `${message}. If the log has another layout, describe a line of it with a regular expression: (?<data>...) is the bytes in hexadecimal, (?<time>...) and (?<dir>...) are optional.`,
    [field("pattern", "Pattern of a line", element("input", { type: "text", id: "pattern", placeholder: "(?<time>[^;]*);(?<dir>[^;]*);(?<data>.*)" }))],
    "Try again", ({ pattern }) => pattern && done(pattern));
}

const PARTS = [
  ["Part", "Licence", "Source"],
  ["this page, sis.lua, sistap", "GPL-2.0-or-later", "the project that this page is from, in lua-fallback/ and capture/"],
  ["Wireshark 4.4.5", "GPL-2.0-or-later", "https://www.wireshark.org/download/src/all-versions/"],
  ["wiregasm 1.9.1, which builds it for WebAssembly", "GPL-2.0-only", "https://github.com/good-tools/wiregasm; its package says GPLV2, and nothing of later versions"],
  ["in it: GLib, libgcrypt, libgpg-error", "LGPL-2.1-or-later", "as wiregasm's lib/Makefile names them"],
  ["in it: Lua, c-ares, nghttp2, libffi", "MIT", "as wiregasm's lib/Makefile names them"],
  ["in it: PCRE2; zlib", "BSD-3-Clause; Zlib", "as wiregasm's lib/Makefile names them"],
  ["Pyodide 314.0.7, with Emscripten's runtime", "MPL-2.0, MIT", "https://github.com/pyodide/pyodide"],
  ["CPython 3.14", "PSF-2.0", "https://github.com/python/cpython"],
];

// The texts of the licences, unpacked when they are wanted.
function licenceTexts() {
  const text = element("pre", { className: "licences", tabIndex: 0, role: "region", "aria-label": "Texts of the licences" });
  const show = async () => (text.textContent ||= await partText("licences.txt").catch(({ message }) => message));
  return element("details", { ontoggle: show }, element("summary", {}, "The texts of the licences"), text);
}

export function about() {
  const dialog = element("dialog", { "aria-labelledby": "about-title", onclose: () => dialog.remove() },
    element("h2", { id: "about-title" }, "About this page"),
    element("p", {}, "It shows the SIS protocol of Rexroth and Indramat drives with Wireshark's own dissection. It loads nothing and sends nothing. ",
      "The handbook is in the folder docs beside this file, if it was made: ",
      element("a", { href: "docs/index.html", target: "_blank", rel: "noopener" }, "Help"), ". ",
      "The whole is under the GNU General Public License, version 2, without any warranty. Most parts allow a later version, too."),
    table(PARTS, { name: "Parts and their licences" }), licenceTexts(), button("Close", () => dialog.close()));
  document.body.append(dialog);
  dialog.showModal();
}
