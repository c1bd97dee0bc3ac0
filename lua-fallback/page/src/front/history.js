// SPDX-License-Identifier: GPL-2.0-or-later
// The filters of the view of packets are in the history of the browser: Back uses the one before. The state of an entry is
// {capture, filter}; `capture` counts what was opened, because a filter is of one capture.

const HASH = "#packets";
const isShown = () => location.hash.split("/")[0] === HASH;

export function rememberFilters(capture, showing) {
  const numbers = new WeakMap(); // of captures, by their bytes
  let opened = 0, count = 0;
  const now = () => ({ capture: opened, filter: capture.filter });
  const isNow = (state) => state?.capture === opened && state.filter === capture.filter;

  capture.addEventListener("opened", () => {
    if (!numbers.has(capture.bytes)) numbers.set(capture.bytes, ++count);
    opened = numbers.get(capture.bytes);
  });
  capture.addEventListener("filtered", () => {
    if (!isShown() || isNow(history.state)) return;
    if (history.state?.capture === opened) history.pushState(now(), "", HASH);
    else history.replaceState(now(), "", HASH);
  });
  addEventListener("popstate", ({ state }) => {
    if (!isShown() || !capture.isOpen) return;
    const told = filterIn(location.hash);
    if (!state && !told) history.replaceState(now(), "", HASH); // a link has led here
    const filter = state ? state.capture === opened && state.filter : told || false;
    if (filter !== false && filter !== capture.filter) showing(() => capture.setFilter(filter));
  });
}

// A person can write a filter into the address: #packets/sis.status%20%3E%200
function filterIn(hash) {
  const text = hash.slice(HASH.length + 1);
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}
