// SPDX-License-Identifier: GPL-2.0-or-later
// Parts of the page: {bytes, isPacked} in the one file, {address, isPacked} in the folder.

export async function unpacked(part) {
  return new Uint8Array(await (await opened(part)).arrayBuffer());
}

export async function text(part) {
  return (await opened(part)).text();
}

// Compiles a part while it is unpacked; a part that is compiled already is itself.
export async function module(part) {
  if (part instanceof WebAssembly.Module) return part;
  const headers = { "Content-Type": "application/wasm" };
  return WebAssembly.compileStreaming(new Response((await opened(part)).body, { headers }));
}

// The buffers of parts, to move them to a worker.
export const buffers = (...parts) => parts.flatMap(({ bytes }) => bytes?.buffer ?? []);

async function opened({ bytes, address, isPacked }) {
  const packed = bytes ? new Response(bytes) : await fetched(address);
  return isPacked ? new Response(packed.body.pipeThrough(new DecompressionStream("gzip"))) : packed;
}

async function fetched(address) {
  const response = await fetch(address);
  if (!response.ok) throw new Error(`${address}: ${response.status} ${response.statusText}. Load the page again`);
  return response;
}
