// SPDX-License-Identifier: GPL-2.0-or-later
// Builds the page: node build.mjs NPM OUT makes OUT/sis.html, which is one file, and OUT/page/, a folder for a web server.
// NPM is the folder of packages that npm ci has made. README.md says what is where.

import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join, relative, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

import { withoutEval } from "./wiregasm.mjs";

if (process.argv.length !== 4) throw new Error("usage: node build.mjs NPM OUT");
const [npm, out] = process.argv.slice(2).map((path) => resolve(path));
const here = fileURLToPath(new URL(".", import.meta.url)); // Debian 12 has node 18
const repository = join(here, "..", "..");
const sistap = join(repository, "capture", "sistap");
const packages = join(npm, "node_modules");
const { build } = createRequire(join(npm, "package.json"))("esbuild");

const source = (...path) => readFileSync(join(here, "src", ...path), "utf8");
const profile = (name) => readFileSync(join(sistap, "profile", "SIS", name));
const wiregasm = (name) => readFileSync(join(packages, "@goodtools/wiregasm/dist", name));
const pyodide = (name) => readFileSync(join(packages, "pyodide", name));

async function bundled(entry) {
  const { outputFiles } = await build({
    entryPoints: [join(here, "src", entry)],
    bundle: true,
    write: false,
    format: "iife",
    charset: "utf8",
    nodePaths: [packages],
    external: ["node:*", "ws"],
    define: { "import.meta.url": "self.location.href" },
    logLevel: "error",
  });
  return outputFiles[0].text;
}

// The packages sistap and sisbus as {path: text}.
function python() {
  const files = {};
  const capture = join(sistap, "..");
  for (const name of ["sistap", "sisbus"]) {
    for (const entry of readdirSync(join(capture, name), { recursive: true, withFileTypes: true })) {
      const path = join(entry.parentPath, entry.name);
      if (!entry.isFile() || path.includes("__pycache__") || path.endsWith("sis.lua")) continue;
      files[relative(capture, path)] = readFileSync(path, "utf8");
    }
  }
  return JSON.stringify({ ...files, "rows.lua": source("tap", "rows.lua") });
}

// The texts of all licences, one below the other, that of the whole first.
function licences() {
  const others = ["notices", "lgpl-2.1", "mpl-2.0", "python"].map((name) => join(here, "licences", `${name}.txt`));
  return [join(repository, "LICENSE"), ...others].map((path) => readFileSync(path, "utf8").replace(/^\n+|\s+$/g, "")).join(`\n\n\n${"=".repeat(78)}\n\n\n`);
}

// What comes from Python: see content.py.
const content = JSON.parse(execFileSync("python3", [join(here, "content.py")], { maxBuffer: 1 << 28 }));

// What the page consists of: name, bytes, and whether they are packed. Wireshark starts while the browser reads the rest.
async function parts() {
  const ours = withoutEval(wiregasm("wiregasm.js").toString());
  const first = {
    "sis.lua": readFileSync(join(here, "..", "sis.lua")),
    "page.lua": source("dissect", "page.lua"),
    "lanes.lua": source("dissect", "lanes.lua"),
    ...Object.fromEntries(["preferences", "colorfilters", "dmacros"].map((name) => [name, profile(name)])),
    ...Object.fromEntries(["dfilter_buttons", "io_graphs", "recent"].map((name) => [name, profile(name)])),
    "dissect.js": ours + (await bundled("dissect/worker.js")),
  };
  const later = {
    "tap.js": ours + (await bundled("tap/worker.js")),
    "sistap.json": python(),
    "course.json": JSON.stringify(content.course),
    "licences.txt": licences(),
    "python.wasm": pyodide("pyodide.asm.wasm"),
  };
  const packed = ([name, bytes]) => ({ name, bytes: gzipSync(bytes, { level: 9 }), isPacked: true });
  return [
    ...Object.entries(first).map(packed),
    { name: "wireshark.data", bytes: wiregasm("wiregasm.data.gz"), isPacked: true },
    { name: "wireshark.wasm", bytes: wiregasm("wiregasm.wasm.gz"), isPacked: true },
    ...Object.entries(later).map(packed),
    { name: "python.zip", bytes: pyodide("python_stdlib.zip"), isPacked: false },
  ];
}

const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;

// Nothing may come from elsewhere, and nothing may go there. `own` are the files of the folder.
function policy({ style, script, own = "" }) {
  const rules = {
    "default-src": "'none'",
    "style-src": `${[style, ...content.styles.map(hash)].join(" ")}`,
    "script-src": `${script} blob: 'wasm-unsafe-eval'`,
    "worker-src": `blob: ${own}`,
    "connect-src": `blob: ${own}`,
    "img-src": `data: blob: ${own}`,
    "frame-src": "'none'",
    "manifest-src": own || "'none'",
    "base-uri": "'none'",
    "form-action": "'none'",
  };
  return Object.entries(rules).map((rule) => rule.join(" ").trim()).join("; ");
}

function filled(template, values) {
  return template.replace(/\{\{(\w+)\}\}/g, (_, name) => values[name]);
}

const script = await bundled("front/main.js");
const style = source("page.css");
const all = await parts();
const template = source("page.html");

const inside = all.map(({ name, bytes, isPacked }) =>
  `<script type="text/plain" data-part="${name}"${isPacked ? " data-packed" : ""}>${bytes.toString("base64")}</script>`);
writeFileSync(join(out, "sis.html"), filled(template, {
  policy: policy({ style: hash(style), script: hash(script) }),
  head: `<style>${style}</style>`,
  parts: inside.join("\n"),
  script: `<script>${script}</script>`,
}));

const folder = join(out, "page");
rmSync(folder, { recursive: true, force: true });
mkdirSync(join(folder, "parts"), { recursive: true });
const linked = all.map(({ name, bytes, isPacked }) => {
  writeFileSync(join(folder, "parts", name), bytes);
  return `<link data-part="${name}"${isPacked ? " data-packed" : ""} data-address="parts/${name}">`;
});
const stamp = createHash("sha256").update(script + style).update(Buffer.concat(all.map(({ bytes }) => bytes))).digest("hex");
const files = {
  "page.css": style,
  "page.js": script,
  "page.webmanifest": source("page.webmanifest"),
  "icon.svg": source("icon.svg"),
};
files["service.js"] = filled(source("service.js"), { stamp: stamp.slice(0, 16),
  files: ["./", "index.html", ...Object.keys(files), ...all.map(({ name }) => `parts/${name}`)].join(" ") });
for (const [name, text] of Object.entries(files)) writeFileSync(join(folder, name), text);
writeFileSync(join(folder, "index.html"), filled(template, {
  policy: policy({ style: "'self'", script: "'self'", own: "'self'" }),
  head: `<link rel="stylesheet" href="page.css"><link rel="manifest" href="page.webmanifest"><link rel="icon" href="icon.svg">`,
  parts: linked.join("\n"),
  script: `<script src="page.js"></script>`,
}));
