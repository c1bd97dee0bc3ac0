// SPDX-License-Identifier: GPL-2.0-or-later
// The items of a packet's tree.

// Yields all of them, from the outside in.
export function* items(tree) {
  for (const item of tree) {
    yield item;
    yield* items(item.tree);
  }
}

// The name of an item's field; the filter of an item is "name == value".
export const nameOf = ({ filter }) => filter.split(" ")[0];

export const allOf = (tree, ...names) => [...items(tree)].filter((item) => names.includes(nameOf(item)));

export const firstOf = (tree, name) => allOf(tree, name)[0];

// What Wireshark shows of an item: what it has found out itself, and not read in the bytes, is in brackets.
export const textOf = ({ label, isGenerated }) => (isGenerated && !/^\[.*\]$/s.test(label) ? `[${label}]` : label);

// A tree without what Wireshark judges: a learner is to do that.
export const withoutVerdicts = (tree) => tree.filter((item) => !/verdict$|^_ws\.expert/.test(nameOf(item)))
  .map((item) => ({ ...item, severity: "", tree: withoutVerdicts(item.tree) }));

// Protocols of ours that are a telegram, or a packet of it.
export const PROTOCOLS = ["sis", "sisascii", "3964r", "arcnet7f", "synaxpk", "synaxpd", "synaxobj", "synaxpcp"];

// The telegram in a packet's tree; undefined if it has none.
export const layerOf = ({ tree }) => tree.find(({ filter }) => PROTOCOLS.includes(filter));

export const asHex = (bytes, between = " ") => Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join(between);
