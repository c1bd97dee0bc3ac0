// SPDX-License-Identifier: GPL-2.0-or-later
// A menu where the pointer is: right click, or the Menu key. And copying, also in a page that is a file.

import { element } from "./dom.js";

const STEPS = { ArrowDown: 1, ArrowUp: -1 };
/** @type {(how?: {isLeft?: boolean}) => void} */ let close = () => {}; // the menu that is open

const focused = () => /** @type {HTMLElement | null} */ (document.activeElement);

// Opens a menu at {x, y}. `entries` are {words, act, isOn}: `isOn` of those that are ticked on and off; false is left out.
export function openMenu(entries, { x, y }, name) {
  close();
  const before = focused();
  const list = element("ul", { className: "menu", role: "menu", "aria-label": name, onkeydown: (event) => press(event, list) },
    ...entries.filter(Boolean).map(({ words, act, isOn }) => element("li", {
      role: isOn === undefined ? "menuitem" : "menuitemcheckbox", tabIndex: -1, "aria-checked": isOn === undefined ? undefined : String(isOn),
      onclick: () => {
        close();
        act();
      } }, words)));
  const leave = ({ target }) => list.contains(target) || close({ isLeft: true });
  close = ({ isLeft = false } = {}) => {
    removeEventListener("pointerdown", leave, true);
    list.remove();
    close = () => {};
    if (!isLeft) before?.focus({ preventScroll: true });
  };
  list.addEventListener("focusout", ({ relatedTarget }) => relatedTarget && !list.contains(relatedTarget) && close({ isLeft: true }));
  addEventListener("pointerdown", leave, true);
  document.body.append(list);
  list.style.left = `${Math.max(Math.min(x, document.body.clientWidth - list.offsetWidth), 0)}px`;
  list.style.top = `${Math.max(Math.min(y, innerHeight - list.offsetHeight), 0)}px`;
  list.firstChild?.focus({ preventScroll: true });
}

function press(event, list) {
  const { key } = event, all = [...list.children], place = all.indexOf(document.activeElement);
  if (key in STEPS) all.at((place + STEPS[key]) % all.length).focus();
  else if (key === "Home" || key === "End") all.at(key === "Home" ? 0 : -1).focus();
  else if (key === "Enter" || key === " ") all[place]?.click();
  else if (key === "Escape" || key === "Tab") close();
  else return;
  event.preventDefault();
  event.stopPropagation();
}

// Where a menu of an event belongs: at the pointer, or at an element if a key asked for it.
export function placeOf(event, fallback) {
  if (event.button === 2 || event.pointerType === "touch") return { x: event.clientX, y: event.clientY };
  const box = (fallback ?? event.target).getBoundingClientRect();
  return { x: box.left + 8, y: box.bottom };
}

export async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
  } catch { // a page in a file has none, or may not
    const before = focused();
    const field = element("textarea", { className: "visually-hidden", value: text, "aria-hidden": "true" });
    document.body.append(field);
    field.select();
    document.execCommand("copy");
    field.remove();
    before?.focus({ preventScroll: true });
  }
}

// Ctrl+C copies what `text` returns, unless a person has marked a text.
export function copying(root, text) {
  root.addEventListener("keydown", (event) => {
    if (event.key.toLowerCase() !== "c" || !(event.ctrlKey || event.metaKey) || event.shiftKey || event.altKey || String(document.getSelection())) return;
    event.preventDefault();
    copy(text());
  });
}
