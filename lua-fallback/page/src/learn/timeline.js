// SPDX-License-Identifier: GPL-2.0-or-later
// The characters of a packet on a line of time. Whoever moves one, or changes what the tap knew, sees what Wireshark says
// of it then. Nothing is judged here.

import { button, element, findAll } from "../front/dom.js";
import { allOf, firstOf } from "../front/items.js";
import { Bench } from "./bench.js";
import { Characters } from "./characters.js";
import { picture } from "./picture.js";

const MS = 1e6; // in ns
const FLAGS = { 1: "came in one read with the character before", 2: "parity or framing error", 4: "break", 8: "characters were lost before it" };
const SAID = ["sis.checksum", "sis.tza.interval_max", "sis.tza.limit", "sis.tza.verdict", "sis.reaction_time", "sis.trs.limit",
  "sis.trs.verdict", "_ws.expert"];
const VERDICTS = ["good", "warning", "note"]; // ok, exceeded, unresolved

// In ms. Each shows a field of the packet, and changes it, or a preference.
const SLIDERS = [
  { words: "Uncertainty of the tap", min: 0, max: 17, step: 0.1, field: "sertap.uncertainty" },
  { words: "TzA", min: 1, max: 20, step: 1, field: "sis.tza.limit", preference: "sis.tza_ms" },
  { words: "TrS", min: 1, max: 100, step: 1, field: "sis.trs.limit", preference: "sis.trs_ms" },
];

// `selected()` returns {bytes, number, packet} of the capture, `preferences` are those of the lesson.
export const timeline = (selected, preferences) => new Timeline(selected, preferences).root;

class Timeline {
  constructor(selected, preferences) {
    this.selected = selected;
    this.preferences = preferences;
    this.characters = null;
    this.bench = new Bench((packets) => this.show(packets));
    this.picture = element("div", { className: "picture" });
    this.about = element("div", { className: "character" });
    this.sliders = SLIDERS.map((/** @type {any} */ slider) => ({ ...slider, ...range(slider, (ms) => this.slide(slider, ms)) }));
    this.said = element("ul", { className: "verdicts" });
    this.root = element("details", { className: "tool", ontoggle: () => this.root.open && !this.characters && this.take() },
      element("summary", {}, "A timeline to change"),
      element("p", {}, "Drag a character, or choose it and use the arrow keys. Wireshark judges at once."),
      element("p", { className: "tool-buttons" }, button("Take the selected packet", () => this.take())),
      this.picture, this.about, element("div", { className: "sliders" }, ...this.sliders.map(({ root }) => root)),
      element("div", { role: "status" }, this.said));
  }

  take() {
    const { bytes, number, packet } = this.selected();
    if (!bytes || !packet) return;
    const command = firstOf(packet.tree, "sis.command_in")?.to;
    this.characters = new Characters(bytes, command ? [command, number] : [number]);
    this.chosen = null;
    this.limits = {};
    this.update();
  }

  update() {
    const { editable, numbers } = this.characters;
    this.bench.set(editable.bytes.slice(), numbers, { ...this.preferences, ...this.limits });
  }

  slide({ field, preference }, ms) {
    if (!this.characters) return;
    if (preference) this.limits[preference] = ms;
    else this.characters.setAll(field, Math.round(ms * MS));
    this.update();
  }

  show(packets) {
    const { characters } = this;
    characters.read(packets);
    if (!characters.lanes.at(-1).length) {
      this.picture.replaceChildren(element("p", {}, "This packet has no characters of a tap: select another one, and take it."));
      return;
    }
    this.draw();
    this.showChosen();
    const { tree } = packets.at(-1);
    this.said.replaceChildren(...saidOf(tree));
    for (const { field, preference, show } of this.sliders) {
      show(this.limits[preference] ?? firstOf(tree, field)?.label.match(/: ([\d.]+) ms/)?.[1]);
    }
  }

  draw() {
    const focused = /** @type {HTMLElement | null} */ (document.activeElement)?.dataset.character;
    this.picture.replaceChildren(picture(this.characters, this.chosen?.id, {
      choose: (one) => {
        this.chosen = one;
        this.showChosen();
      },
      move: (one, ns) => {
        this.characters.move(one, ns);
        this.update();
      },
    }));
    if (focused) this.picture.querySelector(`[data-character="${focused}"]`)?.focus();
  }

  // What can be changed of the chosen character beside its time.
  showChosen() {
    const { about, chosen, characters } = this;
    if (!chosen) return about.replaceChildren();
    const [value, flags] = ["value", "flags"].map((which) => Number(characters.get(chosen, which)));
    const flip = (which, bits) => {
      characters.flip(chosen, which, bits);
      this.update();
    };
    const active = findAll("button, input", about).indexOf(document.activeElement);
    about.replaceChildren(element("b", {}, `Character ${chosen.place + 1}: `),
      ...[7, 6, 5, 4, 3, 2, 1, 0].map((bit) => button(String((value >> bit) & 1), () => flip("value", 1 << bit), { "aria-label": `Bit ${bit}` })),
      " ", ...Object.entries(FLAGS).map(([bits, words]) => element("label", {},
        element("input", { type: "checkbox", checked: Boolean(flags & Number(bits)), onchange: () => flip("flags", Number(bits)) }), ` ${words} `)));
    if (active >= 0) findAll("button, input", about)[active]?.focus();
    return undefined;
  }
}

// What Wireshark says of a packet's times and checksum.
function saidOf(tree) {
  return allOf(tree, ...SAID).filter(({ label }) => !/^Checksum Status/.test(label)).map(({ label, severity, filter }) => {
    const verdict = filter.match(/verdict == (\d)/)?.[1];
    return element("li", { className: `said-${VERDICTS[verdict] ?? (severity || "none").toLowerCase()}` }, label);
  });
}

function range({ words, min, max, step }, act) {
  const id = `slider-${words.replace(/\W/g, "")}`;
  const value = element("output", {}, "none");
  const input = element("input", { type: "range", id, min, max, step, value: min, oninput: () => {
    value.textContent = `${input.value} ms`;
    act(Number(input.value));
  } });
  return {
    root: element("p", {}, element("label", { htmlFor: id }, `${words} `), input, " ", value),
    show(ms) {
      if (document.activeElement === input) return;
      value.textContent = ms === undefined ? "none" : `${ms} ms`;
      if (ms !== undefined) input.value = ms;
    },
  };
}
