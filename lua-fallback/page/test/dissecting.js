// SPDX-License-Identifier: GPL-2.0-or-later
// Runs in the page, in a browser: startDissecting() starts the page's worker once more, dissected() prints of a capture
// what dissect.mjs prints of it in node.

{
  const TEXTS = ["page.lua", "sis.lua", "lanes.lua", "preferences", "colorfilters", "dmacros"];
  let number = 0, worker = null;
  const bytesOf = (base64) => Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  const part = (name) => {
    const holder = document.querySelector(`[data-part="${name}"]`);
    return { bytes: bytesOf(holder.textContent), isPacked: "packed" in holder.dataset };
  };
  const text = ({ bytes }) => new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();

  const call = (name, ...args) => new Promise((resolve, reject) => {
    const id = ++number;
    const hear = ({ data }) => {
      if (data.id !== id || data.progress !== undefined) return;
      worker.removeEventListener("message", hear);
      if (data.error === undefined) resolve(data.result);
      else reject(new Error(data.error));
    };
    worker.addEventListener("message", hear);
    worker.postMessage({ id, name, args });
  });

  globalThis.startDissecting = async (preferences, others) => {
    worker?.terminate();
    worker = new Worker(URL.createObjectURL(new Blob([await text(part("dissect.js"))], { type: "text/javascript" })));
    await new Promise((resolve) => worker.addEventListener("message", resolve, { once: true })); // it is ready
    const texts = await Promise.all(TEXTS.map(async (name) => [name, await text(part(name))]));
    await call("start", { code: part("wireshark.wasm"), data: part("wireshark.data"), files: { ...Object.fromEntries(texts), ...others } });
    await call("prefer", preferences);
  };

  globalThis.dissected = async (base64, most) => {
    const { packets } = await call("open", bytesOf(base64));
    const { rows } = await call("rows", "", 0, 0);
    const step = Math.ceil(packets / most), trees = [];
    for (let packet = step; packet <= packets; packet += step) trees.push((await call("packet", packet)).tree);
    return JSON.stringify({ columns: rows.map(({ cells }) => cells), step, trees });
  };
}
