// SPDX-License-Identifier: GPL-2.0-or-later
// The tree of a packet. What was open stays open for the next packet, by the names of fields. Nodes are of all items;
// elements are made when a branch is opened, and of a long branch in portions.

import { button, element } from "./dom.js";
import { asFilters } from "./applying.js";
import { textOf, withoutVerdicts } from "./items.js";

const OPEN_AT_FIRST = ["sis", "3964r", "rk512i", "synaxobj", "synaxpk"];
const LONGEST = 200; // characters of a filter that are shown
const PORTION = 500; // items of a branch that are made at once
const nameOf = ({ filter, label }) => filter.match(/[a-z0-9_]\w*(\.\w+)*/i)?.[0] ?? label.replace(/[\d:].*/, "");

// One item: {item, above, place, below, isOpen, begin, end}. Of `below` those from begin to end are elements; there are none
// as long as `end` is 0.
function nodesOf(tree, above, all) {
  return tree.map((item, place) => {
    const node = { item, above, place, isOpen: false, begin: 0, end: 0, below: [] };
    all.push(node);
    node.below = nodesOf(item.tree, node, all);
    return node;
  });
}

export class Tree {
  constructor(capture, { onfilter }) {
    this.capture = capture;
    this.open = new Set(OPEN_AT_FIRST);
    this.items = []; // all nodes, from the outside in
    this.elements = new Map(); // by node
    this.nodes = new WeakMap(); // by element
    this.root = element("ul", { className: "tree", role: "tree", "aria-label": "Fields of the packet",
      onclick: (event) => this.click(event), onkeydown: (event) => this.press(event),
      ondblclick: (event) => this.toggle(this.nodeAt(event.target)) });
    this.said = element("p", { className: "field-bar", role: "status" });
    this.onfilter = onfilter;
    capture.addEventListener("selected", () => this.draw());
    capture.addEventListener("marked", () => this.showMark());
    capture.addEventListener("wanted", ({ detail }) => this.show(this.items.find((one) => nameOf(one.item) === detail)));
  }

  get chosenElement() {
    return this.elements.get(this.chosen);
  }

  nodeAt(target) {
    return this.nodes.get(target.closest("li"));
  }

  draw() {
    const kept = this.chosen && nameOf(this.chosen.item);
    this.items = [];
    this.elements.clear();
    this.chosen = null;
    const tree = this.capture.packet?.tree ?? [];
    this.top = nodesOf(this.root.closest(".raw") ? withoutVerdicts(tree) : tree, null, this.items);
    this.root.replaceChildren(...this.top.map((node) => this.made(node)));
    if (this.top.length) this.elements.get(this.top[0]).tabIndex = 0;
    const again = kept && this.items.find((one) => nameOf(one.item) === kept && this.isSeen(one));
    this.choose(again || null, { isQuiet: true });
  }

  isSeen({ above, place }) {
    return !above || (above.isOpen && above.begin <= place && place < above.end && this.isSeen(above));
  }

  made(node) {
    const { item } = node;
    const label = element("span", { className: item.type === "framenum" ? "label link" : "label", textContent: textOf(item) });
    const made = element("li", { role: "treeitem", tabIndex: -1, className: `severity-${(item.severity || "none").toLowerCase()}` }, label);
    this.elements.set(node, made);
    this.nodes.set(made, node);
    if (!node.below.length) return made;
    made.setAttribute("aria-expanded", "false");
    if (this.open.has(nameOf(item))) this.unfold(node);
    return made;
  }

  // Shows what is in a branch: the portion that has the item `at`.
  unfold(node, at = 0) {
    node.isOpen = true;
    const made = this.elements.get(node);
    made.setAttribute("aria-expanded", "true");
    if (node.begin <= at && at < node.end) return;
    node.begin = at - (at % PORTION);
    node.end = Math.min(node.begin + PORTION, node.below.length);
    made.querySelector(":scope > ul")?.remove();
    made.append(element("ul", { role: "group" }, ...this.portion(node, node.begin, node.end)));
    this.tellMore(node);
  }

  portion({ below }, begin, end) {
    return below.slice(begin, end).map((one) => this.made(one));
  }

  // Makes the next portion of a branch, or the one before.
  extend(node, isBefore) {
    const group = this.elements.get(node).lastChild;
    group.querySelectorAll(":scope > .more").forEach((one) => one.remove());
    if (isBefore) {
      const begin = Math.max(node.begin - PORTION, 0);
      group.prepend(...this.portion(node, begin, node.begin));
      node.begin = begin;
    } else {
      const end = Math.min(node.end + PORTION, node.below.length);
      group.append(...this.portion(node, node.end, end));
      node.end = end;
    }
    this.tellMore(node);
  }

  // What is left out at both ends of a branch; a click shows more of it.
  tellMore(node) {
    const group = this.elements.get(node).lastChild, count = node.below.length;
    const line = (isBefore, left) => element("li", { role: "none", className: "more", onclick: (event) => {
      event.stopPropagation();
      this.extend(node, isBefore);
    } }, element("span", { className: "label link" }, `Show ${Math.min(PORTION, left)} more: ${left.toLocaleString("en")} are ${isBefore ? "before" : "after"} these`));
    if (node.begin > 0) group.prepend(line(true, node.begin));
    if (node.end < count) group.append(line(false, count - node.end));
  }

  toggle(node, isOpen = !node?.isOpen) {
    if (!node?.below.length) return;
    const name = nameOf(node.item);
    if (isOpen) {
      this.open.add(name);
      this.unfold(node, node.begin);
    } else {
      this.open.delete(name);
      node.isOpen = false;
      this.elements.get(node).setAttribute("aria-expanded", "false");
    }
  }

  // Chooses an item: its bytes light up, and its filter stands below.
  choose(node, { isQuiet = false } = {}) {
    this.elements.get(this.chosen)?.removeAttribute("aria-selected");
    this.chosen = node;
    if (node) {
      this.root.querySelectorAll('[tabindex="0"]').forEach((one) => (one.tabIndex = -1));
      const made = this.elements.get(node);
      made.tabIndex = 0;
      made.setAttribute("aria-selected", "true");
      if (!isQuiet) focusOn(made);
    }
    const item = node?.item ?? null;
    this.capture.mark = item && item.length ? { start: item.start, length: item.length, source: item.source } : null;
    this.capture.marker = this;
    this.capture.tell("marked");
    this.say(item);
  }

  say(item) {
    if (!item?.filter) {
      this.said.replaceChildren(item ? "This line has no filter." : "Choose a field: its filter is then here.");
      return;
    }
    this.said.replaceChildren(element("code", {}, item.filter.length > LONGEST ? `${item.filter.slice(0, LONGEST)}…` : item.filter),
      ...asFilters(this.capture.filter, item.filter).flatMap(({ words, filter }) => [" ", button(words, () => this.onfilter(filter))]));
  }

  // The smallest field that holds a byte that was chosen elsewhere.
  showMark() {
    const { mark, marker } = this.capture;
    if (marker === this || !mark) return;
    const fits = this.items.filter(({ item }) => item.source === mark.source && item.length && !/^(frame|exported_pdu)\b/.test(item.filter)
      && item.start <= mark.start && mark.start < item.start + item.length);
    const one = fits.reduce((best, next) => (best && best.item.length < next.item.length ? best : next), null);
    this.show(one);
  }

  // Opens what is around an item, and chooses it.
  show(node) {
    if (!node) return;
    this.reveal(node);
    this.choose(node, { isQuiet: true });
    this.elements.get(node).firstChild.scrollIntoView({ block: "nearest" });
  }

  reveal({ above, place }) {
    if (!above) return;
    this.reveal(above);
    this.open.add(nameOf(above.item));
    this.unfold(above, place);
  }

  click(event) {
    const node = this.nodeAt(event.target);
    if (!node) return;
    if (event.target === this.elements.get(node)) this.toggle(node); // the arrow
    this.choose(node);
    if (event.target.classList.contains("link")) this.jump(node);
  }

  jump(node) {
    if (node?.item.type === "framenum") this.capture.goTo(node.item.to);
    else if (node) this.toggle(node);
  }

  // The item below one, as it is seen.
  after(node) {
    if (node.isOpen) return node.below[node.begin];
    for (let one = node; one; one = one.above) {
      const next = (one.above?.below ?? this.top)[one.place + 1];
      if (next && one.above && one.place + 1 >= one.above.end) this.extend(one.above, false);
      if (next) return next;
    }
    return node;
  }

  // The item above one.
  before(node) {
    const { above, place } = node;
    if (above && place === above.begin && place > 0) this.extend(above, true);
    return place > 0 ? this.lastIn((above?.below ?? this.top)[place - 1]) : above ?? node;
  }

  lastIn(node) {
    return node.isOpen ? this.lastIn(node.below[node.end - 1]) : node;
  }

  press(event) {
    const node = this.nodeAt(event.target);
    if (!node || event.altKey || event.ctrlKey || event.metaKey) return;
    const acts = {
      ArrowDown: () => this.choose(this.after(node)),
      ArrowUp: () => this.choose(this.before(node)),
      Home: () => this.choose(this.top[0]),
      End: () => this.choose(this.lastIn(this.top.at(-1))),
      ArrowRight: () => (node.below.length && !node.isOpen ? this.toggle(node, true) : this.choose(node.isOpen ? this.after(node) : node)),
      ArrowLeft: () => (node.isOpen ? this.toggle(node, false) : this.choose(node.above ?? node)),
      Enter: () => this.jump(node),
      " ": () => this.toggle(node),
    };
    if (!Object.hasOwn(acts, event.key)) return;
    event.preventDefault();
    acts[event.key]();
  }
}

// An element of a long branch is as high as all that is in it; what has to be seen is its first line.
function focusOn(made) {
  made.focus({ preventScroll: true });
  made.firstChild.scrollIntoView({ block: "nearest" });
}
