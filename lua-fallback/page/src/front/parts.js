// SPDX-License-Identifier: GPL-2.0-or-later
// The parts of the page: in the one file its elements hold them, in the folder they name their addresses. The page's
// script begins before the browser has read all of them.

import { text } from "../unpack.js";

export async function part(name) {
  const holder = await elementOf(name);
  const isPacked = "packed" in holder.dataset;
  const { address } = holder.dataset;
  return address ? { address: new URL(address, location.href).href, isPacked } : { bytes: fromBase64(holder.textContent), isPacked };
}

export const partText = async (name) => text(await part(name));

// Returns the address of a worker's script: a part of the page, as a blob.
export async function scriptAddress(name) {
  return URL.createObjectURL(new Blob([await partText(name)], { type: "text/javascript" }));
}

// In the folder for a web server, a service worker keeps all files: from the second visit on the page needs no server.
export function keepParts() {
  const inFolder = document.querySelector("[data-part][data-address]") !== null;
  if (inFolder) navigator.serviceWorker?.register("service.js").catch(() => {}); // without it, the page needs its server
}

// An element that is read to its end has something behind it.
function elementOf(name) {
  return new Promise((resolve, reject) => {
    const look = () => {
      const found = document.querySelector(`[data-part="${CSS.escape(name)}"]`);
      const isThere = Boolean(found?.nextSibling), isOver = document.readyState !== "loading";
      if (isThere) resolve(found);
      else if (isOver) reject(new Error("This page is cut off: copy its file once more"));
      return isThere || isOver;
    };
    if (look()) return;
    const observer = new MutationObserver(() => look() && observer.disconnect());
    observer.observe(document.body, { childList: true });
    document.addEventListener("DOMContentLoaded", look);
  });
}

function fromBase64(packed) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(packed);
  const binary = atob(packed), bytes = new Uint8Array(binary.length);
  for (let place = 0; place < binary.length; place++) bytes[place] = binary.charCodeAt(place);
  return bytes;
}
