// SPDX-License-Identifier: GPL-2.0-or-later
// Starts Wireshark of compiled code, in a worker.

import { unpacked } from "../unpack.js";
import { Dissector } from "./dissector.js";

export async function startDissector(load, { code, data, files }) {
  const { buffer } = await unpacked(data);
  return Dissector.start(load, files, {
    getPreloadedPackage: () => buffer,
    instantiateWasm(imports, done) {
      WebAssembly.instantiate(code, imports).then((instance) => done(instance, code));
      return {};
    },
  });
}
