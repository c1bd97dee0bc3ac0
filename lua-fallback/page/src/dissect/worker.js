// SPDX-License-Identifier: GPL-2.0-or-later
// The worker that runs Wireshark. wiregasm's own script stands before this one and makes `loadWiregasm`.

import { serve } from "../protocol.js";
import { module } from "../unpack.js";
import { startDissector } from "./start.js";

let dissector;

// Those of Dissector's calls whose first argument is the task, and those that need none.
const WITH_TASK = ["open", "rows", "figures", "lanes", "graph"];
const PLAIN = ["prefer", "trouble", "completions", "packet"];

serve({
  // Starts Wireshark; returns its compiled code, for another worker.
  async start(task, parts) {
    const code = await module(parts.code);
    dissector = await startDissector(self.loadWiregasm, { ...parts, code });
    return { code, version: dissector.version };
  },
  ...Object.fromEntries(WITH_TASK.map((name) => [name, (task, ...args) => dissector[name](task, ...args)])),
  ...Object.fromEntries(PLAIN.map((name) => [name, (task, ...args) => dissector[name](...args)])),
}, () => dissector?.memory);
