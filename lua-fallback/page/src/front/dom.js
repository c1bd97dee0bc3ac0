// SPDX-License-Identifier: GPL-2.0-or-later
// Elements. Text from files becomes text nodes and attributes only, never HTML.

export const find = (/** @type {string} */ selector, /** @type {any} */ inside = document) => inside.querySelector(selector);
export const findAll = (/** @type {string} */ selector, /** @type {any} */ inside = document) => [...inside.querySelectorAll(selector)];

// Makes an element: element("a", { href: "#x", onclick: f, "aria-label": "y" }, "text", child, ...).
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (name in made && !name.includes("-")) made[name] = value;
    else if (value !== false && value !== null && value !== undefined) made.setAttribute(name, value === true ? "" : value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined && child !== false));
  return made;
}

export const button = (text, onclick, attributes = {}) => element("button", { type: "button", onclick, ...attributes }, text);

/** Makes a table of texts; the first row is its head. `name` is for those who do not see it, `numeric` says which columns
 * stand to the right, and `cell` what a cell has.
 * @param {string[][]} rows
 * @param {{name: string, numeric?: number[], cell?: (text: string, place: number, row: number) => string | Node}} options */
export function table(rows, { name, numeric = [], cell = (text) => text }) {
  const [head, ...body] = rows;
  const side = (place) => (numeric.includes(place) ? "number" : "");
  return element("div", { className: "wide", tabIndex: 0, role: "region", "aria-label": name },
    element("table", {},
      element("thead", {}, element("tr", {},
        ...head.map((text, place) => text ? element("th", { scope: "col", className: side(place) }, text) : element("td")))),
      element("tbody", {}, ...body.map((row, number) => element("tr", {},
        ...row.map((text, place) => element("td", { className: side(place) }, cell(text, place, number))))))));
}

// Offers bytes or text as a file.
export function save(name, data, type = "text/plain") {
  const address = URL.createObjectURL(data instanceof Blob ? data : new Blob([data], { type }));
  element("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}

export const plural = (count, one, many = `${one}s`) => `${count.toLocaleString("en")} ${count === 1 ? one : many}`;
