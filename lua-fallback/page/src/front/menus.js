// SPDX-License-Identifier: GPL-2.0-or-later
// What can be copied and filtered in the list, the tree and the bytes, by Ctrl+C and by a menu.

import { asFilters } from "./applying.js";
import { allOf, asHex, layerOf, textOf } from "./items.js";
import { copy, copying, openMenu, placeOf } from "./menu.js";

// The bytes of an item.
const bytesOf = ({ sources }, { source, start, length }) => sources[source]?.bytes.subarray(start, start + length) ?? [];

// The bytes of a packet's telegram, or of its last source, such as other characters.
function telegramOf(packet) {
  const layer = layerOf(packet);
  return layer ? bytesOf(packet, layer) : packet.sources.at(-1)?.bytes ?? [];
}

// What stands after the name of a field.
const valueOf = ({ label }) => label.slice(label.indexOf(": ") + 1).trim();

const copyOf = (words, text) => text !== "" && { words, act: () => copy(text) };

const filterEntries = (capture, filter, apply) => (filter ? [copyOf("Copy filter", filter),
  ...asFilters(capture.filter, filter).map((one) => ({ words: one.title, act: () => apply(one.filter) }))] : []);

const itemEntries = (capture, item, apply) => [copyOf("Copy value", valueOf(item)), copyOf("Copy bytes", asHex(bytesOf(capture.packet, item))),
  ...filterEntries(capture, item.filter, apply)];

export function menusOf(capture, { list, tree, bytes }, apply) {
  copying(list.root, () => list.text());
  copying(tree.root, () => (tree.chosen ? textOf(tree.chosen.item) : ""));
  copying(bytes.dump, () => asHex(bytes.chosenBytes()));
  list.root.addEventListener("contextmenu", (event) => event.target.closest(".head-group") || asked(event, () => ofList(event)));
  tree.root.addEventListener("contextmenu", (event) => asked(event, () => ofTree(event)));
  bytes.dump.addEventListener("contextmenu", (event) => asked(event, () => ofBytes(event)));

  function asked(event, show) {
    event.preventDefault();
    if (capture.packet) show();
  }

  // In Wireshark, too, the packet is selected then.
  async function ofList(event) {
    const cell = list.cellAt(event.target), { column, place = list.place } = cell;
    const at = placeOf(event, list.selected);
    if (cell.number) await capture.select(cell.number);
    const { packet, number } = capture;
    if (!packet) return;
    const value = column ? list.text(place, column) : "";
    const filter = column?.field ? allOf(packet.tree, column.field)[0]?.filter : `frame.number == ${number}`;
    openMenu([copyOf("Copy row", list.text(place)), copyOf("Copy value", value), copyOf("Copy bytes", asHex(telegramOf(packet))),
      ...filterEntries(capture, filter, apply)], at, "Packet");
  }

  function ofTree(event) {
    const node = tree.nodeAt(event.target) ?? tree.chosen;
    if (!node) return;
    tree.choose(node);
    openMenu([copyOf("Copy row", textOf(node.item)), ...itemEntries(capture, node.item, apply)], placeOf(event, tree.chosenElement), "Field");
  }

  function ofBytes(event) {
    bytes.chooseAt(event.target);
    const item = tree.chosen?.item;
    const chosen = bytes.chosenBytes(), row = bytes.rowText();
    openMenu([copyOf("Copy row", row), copyOf("Copy bytes", asHex(chosen)), item && copyOf("Copy value", valueOf(item)),
      ...filterEntries(capture, item?.filter, apply)], placeOf(event, bytes.cursorCell), "Bytes");
  }
}
