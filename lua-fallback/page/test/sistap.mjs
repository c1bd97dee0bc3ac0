// SPDX-License-Identifier: GPL-2.0-or-later
// Runs jobs of sistap in Python for WebAssembly. The argument names a file with JSON: a list of {words, files, wanted},
// files by name in base64. Prints a list of {code, said, written, memory}. A job {modules} imports them, and prints what fails.

import { readFileSync } from "node:fs";

import { TASK, startSistap } from "./parts.mjs";

const sistap = await startSistap();
const bytes = (text) => Uint8Array.from(Buffer.from(text, "base64"));
const text = (data) => Buffer.from(data).toString("base64");
const each = (files, of) => Object.fromEntries(Object.entries(files ?? {}).map(([name, value]) => [name, of(value)]));

function imported(modules) {
  const found = sistap.python.runPython(`
import importlib, json
def imported(names):
    found = {}
    for name in names.to_py():
        try:
            importlib.import_module(name)
        except Exception as error:
            found[name] = repr(error)
    return json.dumps(found)
imported`)(modules);
  return JSON.parse(found);
}

const done = JSON.parse(readFileSync(process.argv[2], "utf8")).map(({ words, files, wanted, modules }) => {
  if (modules) return imported(modules);
  const result = sistap.command(TASK, words, each(files, bytes), wanted);
  return { ...result, written: each(result.written, text), memory: sistap.python._module.HEAPU8.length };
});
process.stdout.write(JSON.stringify(done));
