// SPDX-License-Identifier: GPL-2.0-or-later
// Keeps the folder's files, so that the page opens without its server after the first visit.

const PREFIX = "sis-page-";
const STAMP = "{{stamp}}", FILES = "{{files}}".split(" "); // build.mjs fills these in

self.addEventListener("install", (event) => event.waitUntil(keep()));
self.addEventListener("activate", (event) => event.waitUntil(self.clients.claim()));
self.addEventListener("fetch", (event) => event.respondWith(answer(event.request)));

async function keep() {
  const store = await caches.open(PREFIX + STAMP);
  await store.addAll(FILES.map((file) => new Request(file, { cache: "no-cache" })));
  for (const name of await caches.keys()) if (name.startsWith(PREFIX) && name !== PREFIX + STAMP) await caches.delete(name);
  await self.skipWaiting();
}

async function answer(request) {
  const kept = await caches.match(request, { ignoreSearch: true });
  return kept ?? fetch(request);
}
