// SPDX-License-Identifier: GPL-2.0-or-later
// For tests in node: Wireshark and sistap as the page has them. NPM names the folder of packages.

import { readFileSync, readdirSync } from "node:fs";
import { createRequire } from "node:module";
import { join, relative } from "node:path";
import { fileURLToPath } from "node:url";

import { Dissector } from "../src/dissect/dissector.js";
import { OWN_FILES, Sistap } from "../src/tap/sistap.js";
import { withoutEval } from "../wiregasm.mjs";

const here = fileURLToPath(new URL("..", import.meta.url));
const capture = join(here, "..", "..", "capture");
const packages = join(process.env.NPM, "node_modules");
const wiregasm = join(packages, "@goodtools", "wiregasm", "dist");
const profile = join(capture, "sistap", "profile", "SIS");

// The loader of wiregasm as the page has it: without code from text.
function loader() {
  const module = { exports: {} };
  const script = withoutEval(readFileSync(join(wiregasm, "wiregasm.js"), "utf8"));
  // eslint-disable-next-line no-new-func -- a script that was no module
  new Function("module", "exports", "require", "__filename", "__dirname", script)(module, module.exports,
    createRequire(import.meta.url), join(wiregasm, "wiregasm.js"), wiregasm);
  return module.exports;
}

// `others` are more files of the profile, by name.
export function startDissector(others = {}) {
  const names = ["preferences", "colorfilters", "dmacros"];
  const files = {
    "page.lua": readFileSync(join(here, "src", "dissect", "page.lua")),
    "sis.lua": readFileSync(join(here, "..", "sis.lua")),
    "lanes.lua": readFileSync(join(here, "src", "dissect", "lanes.lua")),
    ...Object.fromEntries(names.map((name) => [name, readFileSync(join(profile, name))])),
    ...others,
  };
  return Dissector.start(loader(), files, { locateFile: (name) => join(wiregasm, name) });
}

export async function startSistap() {
  const files = { "rows.lua": readFileSync(join(here, "src", "tap", "rows.lua"), "utf8") };
  for (const name of ["sistap", "sisbus"]) {
    for (const entry of readdirSync(join(capture, name), { recursive: true, withFileTypes: true })) {
      const path = join(entry.parentPath, entry.name);
      if (entry.isFile() && !path.includes("__pycache__")) files[relative(capture, path)] = readFileSync(path, "utf8");
    }
  }
  const { loadPyodide } = await import(join(packages, "pyodide", "pyodide.mjs"));
  const sistap = await Sistap.start(loadPyodide, files, { indexURL: join(packages, "pyodide/") });
  sistap.wireshark = await startDissector(OWN_FILES);
  return sistap;
}

export const TASK = { progress: () => {} };
