// SPDX-License-Identifier: GPL-2.0-or-later
// Opens the page in a headless Firefox, and captures in it: node firefox.mjs FIREFOX PAGE CAPTURE..., over WebDriver BiDi.
// Prints {seconds, rows, hasSerial, complaints} as JSON: how long each took, the first one from the start of the page on.
// NPM names the packages.

import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { pathToFileURL } from "node:url";

const WebSocket = createRequire(join(process.env.NPM, "package.json"))("ws");
const [firefox, page, ...captures] = process.argv.slice(2);
const profile = mkdtempSync(join(tmpdir(), "firefox-"));
const program = spawn(firefox, ["--headless", "--remote-debugging-port", "0", "--profile", profile, "--no-remote"],
  { env: { ...process.env, HOME: profile }, stdio: ["ignore", "ignore", "pipe"] });

async function address() {
  for await (const line of createInterface({ input: program.stderr })) {
    const found = line.match(/WebDriver BiDi listening on (ws:\S+)/);
    if (found) return found[1];
  }
  throw new Error("Firefox does not start");
}

const socket = new WebSocket(`${await address()}/session`);
await new Promise((resolve, reject) => socket.on("open", resolve).on("error", reject));
const calls = new Map(), complaints = [];
socket.on("message", (data) => {
  const message = JSON.parse(data);
  if (message.type === "event") complaints.push(message.params.text ?? message.method);
  else calls.get(message.id)(message);
});
let number = 0;

async function call(method, params) {
  const id = ++number;
  socket.send(JSON.stringify({ id, method, params }));
  const { result, error, message } = await new Promise((resolve) => calls.set(id, resolve));
  if (error) throw new Error(`${method}: ${message}`);
  return result;
}

try {
  await call("session.new", { capabilities: {} });
  const { contexts: [{ context }] } = await call("browsingContext.getTree", {});
  await call("session.subscribe", { events: ["log.entryAdded"] });
  const run = async (expression) => (await call("script.evaluate",
    { expression, target: { context }, awaitPromise: true, serializationOptions: { maxDomDepth: 0 } })).result;
  const until = async (expression) => {
    while (!(await run(`Boolean(${expression})`)).value) await new Promise((resolve) => setTimeout(resolve, 20));
  };
  const seconds = [], rows = [];
  let begin = performance.now();
  await call("browsingContext.navigate", { context, url: pathToFileURL(page).href, wait: "none" });
  for (const capture of captures) {
    await until("document.querySelector('#chooser')");
    const element = await run("location.hash = '#open', document.querySelector('#chooser')");
    await call("input.setFiles", { context, element: { sharedId: element.sharedId }, files: [capture] });
    await until("location.hash === '#packets' && document.querySelector('.packet-list .row.selected')");
    seconds.push((performance.now() - begin) / 1000);
    rows.push((await run("document.querySelector('.packet-list').ariaRowCount - 1")).value);
    begin = performance.now();
  }
  const hasSerial = (await run("'serial' in navigator")).value;
  process.stdout.write(JSON.stringify({ seconds, rows, hasSerial, complaints }));
} finally {
  socket.close();
  program.kill();
  await new Promise((resolve) => program.on("exit", resolve));
  rmSync(profile, { recursive: true, force: true });
}
