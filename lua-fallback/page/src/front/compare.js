// SPDX-License-Identifier: GPL-2.0-or-later
// What `sistap compare` says of the capture that is open and of another one, of a time when all was well.

import { element } from "./dom.js";
import { captureOf, fileName, visible } from "./files.js";
import { framed } from "./framed.js";
import { callTap } from "./tap.js";

const OUT = ".compared.html";

// Returns the page of sistap; a side is {name, bytes}. `options` are those of callTap.
export async function compared(good, bad, options) {
  const names = [fileName(good.name), fileName(bad.name)];
  if (names[0] === names[1]) names[0] = `good ${names[0]}`;
  const sides = { [names[0]]: good.bytes, [names[1]]: bad.bytes };
  const { code, said, written } = await callTap("command", [["compare", ...names, "--format", "html", "-o", OUT], sides, [OUT]], options);
  if (code) throw new Error(said.trim());
  return written[OUT];
}

export function compareView(capture, { showing }) {
  let other = null; // the other capture
  const page = framed("Comparison");
  const role = element("select", { id: "open-is", onchange: () => other && run() },
    element("option", { value: "bad" }, "of the bad time: something was wrong"),
    element("option", { value: "good" }, "of the good time: all was well"));
  const chooser = element("input", { type: "file", id: "other", className: "visually-hidden", onchange: () => {
    const [file] = chooser.files;
    if (file) read(file);
    chooser.value = "";
  } });
  const said = element("p", { role: "status" });
  const root = element("section", { className: "report", "aria-labelledby": "compare-title" },
    element("div", { className: "page short" },
      element("h1", { id: "compare-title" }, "Compare"),
      element("p", {}, "What changed between a time when all was well and a time when it was not? Choose a second capture or log of the same machine."),
      element("p", { className: "form-line" }, element("label", { htmlFor: "open-is" }, "The open capture is"), role),
      element("p", {}, chooser, element("label", { htmlFor: "other", className: "button large" }, "Choose the other capture")), said, page.bar), page.frame);

  const read = (file) => showing(async () => {
    const name = visible(file.name), bytes = new Uint8Array(await file.arrayBuffer());
    const { made } = await captureOf(capture, name, bytes);
    other = { name, bytes: made };
    await run();
  });

  const run = () => showing(async () => {
    page.clear();
    const open = { name: capture.bytesName, bytes: capture.bytes };
    const [good, bad] = role.value === "bad" ? [other, open] : [open, other];
    page.show(await capture.long("Comparing", (options) => compared(good, bad, options)), `${capture.name}-compared.html`);
    said.textContent = `Good: ${good.name}. Bad: ${bad.name}.`;
  });

  capture.addEventListener("opened", () => {
    other = null;
    said.textContent = "";
    page.clear();
  });
  return root;
}
