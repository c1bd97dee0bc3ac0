// SPDX-License-Identifier: GPL-2.0-or-later
// Shapes of a drawing (SVG).

const SVG = "http://www.w3.org/2000/svg";

export function shape(tag, attributes, text = "") {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.textContent = text;
  return made;
}
