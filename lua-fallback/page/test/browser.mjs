// SPDX-License-Identifier: GPL-2.0-or-later
// A headless Firefox, driven over WebDriver BiDi. NPM names the packages.

import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { pathToFileURL } from "node:url";

const WebSocket = createRequire(join(process.env.NPM, "package.json"))("ws");

async function addressOf(program) {
  for await (const line of createInterface({ input: program.stderr })) {
    const found = line.match(/WebDriver BiDi listening on (ws:\S+)/);
    if (found) return found[1];
  }
  throw new Error("Firefox does not start");
}

export class Firefox {
  complaints = [];
  calls = new Map();
  number = 0;

  static async start(path) {
    const firefox = new Firefox();
    firefox.profile = mkdtempSync(join(tmpdir(), "firefox-"));
    firefox.program = spawn(path, ["--headless", "--remote-debugging-port", "0", "--profile", firefox.profile, "--no-remote"],
      { env: { ...process.env, HOME: firefox.profile }, stdio: ["ignore", "ignore", "pipe"] });
    firefox.socket = new WebSocket(`${await addressOf(firefox.program)}/session`);
    await new Promise((resolve, reject) => firefox.socket.on("open", resolve).on("error", reject));
    firefox.socket.on("message", (data) => firefox.take(JSON.parse(data)));
    await firefox.call("session.new", { capabilities: {} });
    const { contexts: [{ context }] } = await firefox.call("browsingContext.getTree", {});
    firefox.context = context;
    await firefox.call("session.subscribe", { events: ["log.entryAdded"] });
    return firefox;
  }

  take(message) {
    if (message.type === "event") this.complaints.push(message.params.text ?? message.method);
    else this.calls.get(message.id)(message);
  }

  async call(method, params) {
    const id = ++this.number;
    this.socket.send(JSON.stringify({ id, method, params }));
    const { result, error, message } = await new Promise((resolve) => this.calls.set(id, resolve));
    if (error) throw new Error(`${method}: ${message}`);
    return result;
  }

  open(page) {
    return this.call("browsingContext.navigate", { context: this.context, url: pathToFileURL(page).href, wait: "none" });
  }

  // The value of an expression of JavaScript: {value}, or {sharedId} of an element.
  async run(expression) {
    const target = { context: this.context };
    return (await this.call("script.evaluate", { expression, target, awaitPromise: true, serializationOptions: { maxDomDepth: 0 } })).result;
  }

  async until(expression) {
    while (!(await this.run(`Boolean(${expression})`)).value) await new Promise((resolve) => setTimeout(resolve, 20));
  }

  // Opens a capture in the page, and waits for its first packet.
  async choose(capture) {
    await this.until("document.querySelector('#chooser')");
    const { sharedId } = await this.run("location.hash = '#open', document.querySelector('#chooser')");
    await this.call("input.setFiles", { context: this.context, element: { sharedId }, files: [capture] });
    await this.until("location.hash === '#packets' && document.querySelector('.packet-list .row.selected')");
  }

  async end() {
    this.socket.close();
    this.program.kill();
    await new Promise((resolve) => this.program.on("exit", resolve));
    rmSync(this.profile, { recursive: true, force: true });
  }
}
