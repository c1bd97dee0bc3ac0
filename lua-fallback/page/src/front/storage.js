// SPDX-License-Identifier: GPL-2.0-or-later
// What this browser remembers for a person, as JSON. A page in a file, or in a private window, may have no storage: then it
// is remembered until the page is closed, by whoever asked.

export function recall(name) {
  try {
    return JSON.parse(globalThis.localStorage.getItem(name) ?? "null");
  } catch {
    return null; // no storage, or not ours
  }
}

export function remember(name, value) {
  try {
    globalThis.localStorage.setItem(name, JSON.stringify(value));
  } catch {
    // see above
  }
}
