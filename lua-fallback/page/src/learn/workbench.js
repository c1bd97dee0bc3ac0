// SPDX-License-Identifier: GPL-2.0-or-later
// A telegram to change byte by byte, bit by bit, while Wireshark decodes it: to play with, or to build what a task asks for.

import { button, element } from "../front/dom.js";
import { asHex, layerOf } from "../front/items.js";
import { callTap } from "../front/tap.js";
import { Tree } from "../front/tree.js";
import { Bench, fits, telegramCapture } from "./bench.js";
import { hex } from "./picture.js";

const EXAMPLE = { protocol: "sis", bytes: [0x02, 0xc3, 0x02, 0x02, 0x10, 0x12, 0x10, 0x03, 0x00, 0x02] };
const INFO = 2; // the column of the profile that tells the telegram
const HEADER = 8, LENGTH = 2, REPEAT = 3; // of SIS
const SUM = /^(?:Checksum|Block check character): .*should be 0x([0-9a-f]{2})/;

// Reads bytes in hexadecimal; null where they are none.
export function readBytes(text) {
  const words = text.replace(/0x|\\x/gi, " ").replace(/[\s,;:.-]+/g, " ").trim();
  const digits = words.split(" ").map((word) => (word.length === 1 ? `0${word}` : word)).join("");
  return /^([0-9a-f]{2})*$/i.test(digits) ? (digits.match(/../g) ?? []).map((pair) => parseInt(pair, 16)) : null;
}

// The telegram of a packet: {protocol, bytes}; undefined if it has none.
export function telegramOf(packet) {
  const layer = packet && layerOf(packet);
  if (!layer) return undefined;
  const { filter: protocol, source, start, length } = layer;
  return { protocol, bytes: [...packet.sources[source].bytes.subarray(start, start + length)] };
}

// What Tree needs of a Capture.
class Shown extends EventTarget {
  packet = null;
  mark = null;
  marker = null;
  filter = "";

  tell(name) {
    this.dispatchEvent(new Event(name));
  }
}

// `selected()` returns the packet that is selected in the list.
export function workbench(selected) {
  const bench = new Workbench({ id: "telegram" });
  bench.fill(EXAMPLE);
  const taking = button("Take the selected packet's telegram", () => bench.take(selected()));
  const root = element("details", { className: "tool", ontoggle: () => root.open && bench.update() },
    element("summary", {}, "A telegram to change"), element("p", {}, "Change a byte or a bit: Wireshark decodes it at once."),
    bench.input, element("p", { className: "tool-buttons" }, taking, " ", ...bench.tools), ...bench.parts);
  return root;
}

// What a task asks to be built: right if Wireshark finds all its conditions in the telegram. The checksum is to be worked
// out. If it is answered, a drive of the virtual bus does that, and its reaction counts, too.
export function telegramField({ conditions, isAnswered }, { id, text, note }) {
  const bench = new Workbench({ id, changed: note });
  const heard = element("p", { className: "heard", role: "status" });
  bench.fill({ protocol: "sis", bytes: readBytes(text) ?? [] });
  const judged = async () => {
    const bytes = readBytes(bench.input.value);
    if (!bytes?.length) return { right: null, say: "Type the bytes of a telegram, such as 02 D9." };
    const reaction = isAnswered ? readBytes(await callTap("answered", [asHex(bytes)])) : [];
    const { met, cells } = await fits(telegramCapture("sis", bytes, ...(reaction.length ? [reaction] : [])), conditions.map(({ filter }) => filter));
    if (isAnswered) heard.textContent = reaction.length ? `A drive answers: ${asHex(reaction).toUpperCase()}  ${cells[INFO]}` : "No drive answers.";
    const open = conditions.filter((_, place) => !met[place]);
    if (open.length) return { right: false, say: open[0].say };
    const left = bytes.length - HEADER - bytes[LENGTH];
    return left === 0 ? { right: true, say: "Right." } : { right: false, say: `The telegram is over before your bytes are: ${left} too many.` };
  };
  const below = element("div", { className: "built" }, ...bench.parts, heard);
  const root = element("div", {}, bench.input, below);
  root.addEventListener("focusin", () => bench.update(), { once: true });
  return { root, judged };
}

class Workbench {
  constructor({ id, changed = null }) {
    this.changed = changed;
    this.chosen = 0; // place of a byte
    this.shown = new Shown();
    this.tree = new Tree(this.shown, { onfilter: () => {} });
    this.bench = new Bench(([packet]) => this.show(packet));
    this.said = element("p", { role: "status" });
    this.input = element("input", { type: "text", id, className: "telegram", spellcheck: false, "aria-label": "Bytes of a telegram, in hexadecimal",
      oninput: () => this.update() });
    this.cells = element("div", { className: "cells", role: "group", "aria-label": "Bytes" });
    this.bits = element("div", { className: "bits", role: "group", "aria-label": "Bits of the byte" });
    this.lengths = button("Set the lengths", () => this.change((bytes) => bytes.length >= HEADER && (bytes[LENGTH] = bytes[REPEAT] = bytes.length - HEADER)));
    this.tools = [button("Set the checksum", () => this.setChecksum()), " ", this.lengths];
    this.parts = [this.cells, this.bits, this.said, this.tree.root];
  }

  fill({ protocol, bytes }) {
    this.protocol = protocol;
    this.lengths.hidden = protocol !== "sis";
    this.input.value = bytes.map(hex).join(" ");
  }

  take(packet) {
    const telegram = telegramOf(packet);
    if (telegram) {
      this.fill(telegram);
      this.update();
    } else {
      this.said.textContent = "The selected packet has no telegram: select another one.";
    }
  }

  show(packet) {
    this.shown.packet = { ...packet, tree: packet.tree.filter(({ filter }) => !/^(frame|exported_pdu)\b/.test(filter)) };
    this.shown.tell("selected");
    this.said.textContent = "";
  }

  update() {
    const bytes = readBytes(this.input.value);
    this.changed?.(this.input.value);
    if (!bytes) {
      this.said.textContent = "Bytes have two hexadecimal digits each, such as 02 D9.";
      return;
    }
    this.chosen = Math.min(this.chosen, Math.max(bytes.length - 1, 0));
    this.showBytes(bytes);
    this.showBits(bytes[this.chosen]);
    if (bytes.length) this.bench.set(telegramCapture(this.protocol, bytes), [1]);
  }

  showBytes(bytes) {
    const { cells, chosen } = this;
    const hadFocus = cells.contains(document.activeElement);
    const choose = (place) => () => {
      this.chosen = place;
      this.update();
    };
    cells.replaceChildren(...bytes.map((byte, place) => button(hex(byte), choose(place), { "aria-pressed": String(place === chosen) })));
    if (hadFocus) cells.children[chosen]?.focus();
  }

  showBits(byte) {
    const { bits } = this;
    const active = [...bits.children].indexOf(document.activeElement);
    const flip = (bit) => () => this.change((bytes) => (bytes[this.chosen] ^= 1 << bit));
    const isSet = (bit) => (byte >> bit) & 1;
    bits.replaceChildren(...(byte === undefined ? [] : [7, 6, 5, 4, 3, 2, 1, 0].map((bit) =>
      button(String(isSet(bit)), flip(bit), { "aria-label": `Bit ${bit}`, "aria-pressed": String(Boolean(isSet(bit))) }))));
    if (active >= 0) bits.children[active]?.focus();
  }

  change(set) {
    const bytes = readBytes(this.input.value);
    if (!bytes) return;
    set(bytes);
    this.input.value = bytes.map(hex).join(" ");
    this.update();
  }

  // Wireshark says where the checksum is, and what it should be.
  setChecksum() {
    const wrong = this.tree.items.map(({ item }) => item).find(({ label }) => SUM.test(label));
    if (!wrong) return;
    const place = wrong.start - layerOf(this.shown.packet).start;
    this.change((bytes) => (bytes[place] = parseInt(wrong.label.match(SUM)[1], 16)));
  }
}
