// SPDX-License-Identifier: GPL-2.0-or-later
// The tree of a packet. What was open stays open for the next packet, by the names of fields.

import { button, element, find } from "./dom.js";

const OPEN_AT_FIRST = ["sis", "3964r", "rk512i", "synaxobj", "synaxpk"];
const nameOf = ({ filter, label }) => filter.match(/[a-z0-9_]\w*(\.\w+)*/i)?.[0] ?? label.replace(/[\d:].*/, "");

export class Tree {
  constructor(capture, { onfilter }) {
    this.capture = capture;
    this.open = new Set(OPEN_AT_FIRST);
    this.items = [];
    this.root = element("ul", { className: "tree", role: "tree", "aria-label": "Fields of the packet",
      onclick: (event) => this.click(event), onkeydown: (event) => this.press(event),
      ondblclick: (event) => this.toggle(event.target.closest("li")) });
    this.said = element("p", { className: "field-bar", role: "status" });
    this.onfilter = onfilter;
    capture.addEventListener("selected", () => this.draw());
    capture.addEventListener("marked", () => this.showMark());
    capture.addEventListener("wanted", ({ detail }) => this.show(this.items.find((one) => nameOf(one.item) === detail)));
  }

  draw() {
    const kept = this.chosen && nameOf(this.chosen.item);
    this.items = [];
    this.chosen = null;
    this.root.replaceChildren(...(this.capture.packet?.tree ?? []).map((item) => this.made(item)));
    const again = kept && this.items.find((one) => nameOf(one.item) === kept);
    if (this.items.length) this.items[0].tabIndex = 0;
    this.choose(again ?? null, { isQuiet: true });
  }

  made(item) {
    const name = nameOf(item);
    const isOpen = item.tree.length > 0 && this.open.has(name);
    const label = element("span", { className: "label", textContent: item.label });
    const made = element("li", { role: "treeitem", tabIndex: -1, className: `severity-${(item.severity || "none").toLowerCase()}` },
      label);
    made.item = item;
    this.items.push(made);
    if (item.type === "framenum") label.classList.add("link");
    if (item.tree.length) {
      made.setAttribute("aria-expanded", isOpen);
      made.append(element("ul", { role: "group" }, ...item.tree.map((below) => this.made(below))));
    }
    return made;
  }

  toggle(one, isOpen = one.getAttribute("aria-expanded") !== "true") {
    if (!one.item.tree.length) return;
    one.setAttribute("aria-expanded", isOpen);
    const name = nameOf(one.item);
    if (isOpen) this.open.add(name);
    else this.open.delete(name);
  }

  // Chooses an item: its bytes light up, and its filter stands below.
  choose(one, { isQuiet = false } = {}) {
    this.chosen?.removeAttribute("aria-selected");
    this.chosen = one;
    if (one) {
      for (const other of this.items) other.tabIndex = -1;
      one.tabIndex = 0;
      one.setAttribute("aria-selected", "true");
      if (!isQuiet) one.focus();
    }
    const item = one?.item ?? null;
    this.capture.mark = item && item.length ? { start: item.start, length: item.length, source: item.source } : null;
    this.capture.marker = this;
    this.capture.tell("marked");
    this.say(item);
  }

  say(item) {
    this.said.replaceChildren();
    if (!item?.filter) return;
    const use = (filter) => () => this.onfilter(filter);
    const { filter } = this.capture;
    this.said.append(element("code", {}, item.filter), " ", button("Filter", use(item.filter)), " ",
      ...(filter ? [button("And", use(`(${filter}) && ${item.filter}`)), " "] : []),
      button("Not", use(`!(${item.filter})`)));
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
  show(one) {
    if (!one) return;
    for (let above = one.parentElement.closest("li"); above; above = above.parentElement.closest("li")) this.toggle(above, true);
    this.choose(one, { isQuiet: true });
    one.scrollIntoView({ block: "nearest" });
  }

  click(event) {
    const one = event.target.closest("li");
    if (!one) return;
    if (event.target === one) this.toggle(one); // the arrow
    this.choose(one);
    if (event.target.classList.contains("link")) this.jump(one);
  }

  jump(one) {
    if (one?.item.type === "framenum") this.capture.goTo(one.item.to);
    else if (one) this.toggle(one);
  }

  get visible() {
    return this.items.filter((one) => {
      for (let above = one.parentElement.closest("li"); above; above = above.parentElement.closest("li")) {
        if (above.getAttribute("aria-expanded") !== "true") return false;
      }
      return true;
    });
  }

  press(event) {
    const one = event.target.closest("li");
    if (!one || event.altKey || event.ctrlKey) return;
    const shown = this.visible, place = shown.indexOf(one);
    const isOpen = one.getAttribute("aria-expanded") === "true";
    const acts = {
      ArrowDown: () => this.choose(shown[place + 1] ?? one),
      ArrowUp: () => this.choose(shown[place - 1] ?? one),
      Home: () => this.choose(shown[0]),
      End: () => this.choose(shown.at(-1)),
      ArrowRight: () => (one.item.tree.length && !isOpen ? this.toggle(one, true) : this.choose(find("li", one) ?? one)),
      ArrowLeft: () => (isOpen ? this.toggle(one, false) : this.choose(one.parentElement.closest("li") ?? one)),
      Enter: () => this.jump(one),
      " ": () => this.toggle(one),
    };
    if (!(event.key in acts)) return;
    event.preventDefault();
    acts[event.key]();
  }
}
