// SPDX-License-Identifier: GPL-2.0-or-later
// The display filter: Wireshark checks and completes it while it is typed, and says in its own words what is wrong.

import { button, element, plural } from "./dom.js";

const WORD = /[\w.]+$/; // what is typed before the cursor
const SHOWN = 12; // completions
const OF_LIMITS = /\bsis\.(tza|trs)\.verdict\b/; // nothing has one where no limit is known
const OF_NO_LIMITS = "TzA and TrS judge what is late. If the bus did not tell them, tell them with Limits.";

export class FilterBar {
  constructor(capture, buttons) {
    this.capture = capture;
    this.choices = element("ul", { className: "choices", role: "listbox", id: "filter-choices", hidden: true, "aria-label": "Fields" });
    this.input = element("input", {
      type: "text", id: "filter", spellcheck: false, autocomplete: "off", autocapitalize: "off", placeholder: "Display filter, such as sis.status > 0",
      role: "combobox", "aria-expanded": "false", "aria-controls": "filter-choices", "aria-autocomplete": "list",
      "aria-label": "Display filter", "aria-describedby": "filter-said",
      oninput: () => this.look(), onkeydown: (event) => this.press(event), onblur: () => this.closeChoices(),
    });
    this.said = element("p", { id: "filter-said", className: "filter-said", role: "status" });
    this.clear = button("Clear", () => this.apply(""));
    const form = element("form", { className: "filter", role: "search", "aria-label": "Packets", onsubmit: (event) => {
      event.preventDefault();
      this.apply(this.input.value);
    } }, element("div", { className: "field" }, this.input, this.choices), element("button", { type: "submit" }, "Apply"), this.clear);
    this.quick = element("div", { className: "quick", role: "group", "aria-label": "Usual filters", onscroll: () => this.fade() }, ...buttons.map(({ name, filter, help }) =>
      button(name, () => this.apply(filter), { title: `${help}: ${filter}` })));
    this.acts = element("div", { className: "acts" });
    this.root = element("div", { className: "filter-bar" }, form, this.quick, this.acts, this.said);
    capture.addEventListener("filtered", () => this.showApplied());
    capture.addEventListener("grown", () => this.input.classList.contains("bad") || this.count());
    new ResizeObserver(() => this.fade()).observe(this.quick);
  }

  // The buttons fade where more of them are.
  fade() {
    const { scrollLeft, clientWidth, scrollWidth } = this.quick;
    this.quick.classList.toggle("goes-on", scrollLeft + clientWidth < scrollWidth - 1);
  }

  async apply(filter) {
    this.input.value = filter;
    this.closeChoices();
    try {
      await this.capture.setFilter(filter.trim());
    } catch (error) {
      this.judge(error.message);
    }
  }

  showApplied() {
    this.input.value = this.capture.filter;
    this.judge("");
  }

  count() {
    const { filter, matched, packets } = this.capture;
    this.said.textContent = filter ? `${matched.toLocaleString("en")} of ${packets.toLocaleString("en")} packets` : plural(packets, "packet");
    if (!matched && OF_LIMITS.test(filter)) {
      this.said.append(element("span", { className: "said-below" }, OF_NO_LIMITS));
    }
  }

  judge(trouble) {
    const isTyped = this.input.value.trim() !== "";
    this.input.classList.toggle("bad", trouble !== "");
    this.input.classList.toggle("good", isTyped && trouble === "");
    this.input.setAttribute("aria-invalid", trouble !== "");
    this.said.classList.toggle("bad", trouble !== "");
    if (trouble) this.said.textContent = trouble;
    else this.count();
  }

  async look() {
    const viewer = await this.capture.viewer;
    const text = this.input.value;
    const before = text.slice(0, this.input.selectionStart).match(WORD)?.[0] ?? "";
    const [trouble, found] = await Promise.all([
      text.trim() ? viewer.call("trouble", [text]) : "",
      before.length > 1 ? viewer.call("completions", [before]) : [],
    ]);
    if (text !== this.input.value) return;
    this.judge(trouble);
    this.offer(found.filter(({ field }) => field !== before).sort((one, other) => one.field.localeCompare(other.field)));
  }

  offer(found) {
    this.chosen = -1;
    this.choices.replaceChildren(...found.slice(0, SHOWN).map(({ field, name }, place) =>
      element("li", { role: "option", id: `choice-${place}`, "aria-selected": "false", onmousedown: (event) => {
        event.preventDefault();
        this.take(field);
      } }, element("code", {}, field), " ", element("small", {}, name))));
    this.fields = found.slice(0, SHOWN).map(({ field }) => field);
    this.choices.hidden = found.length === 0;
    this.input.setAttribute("aria-expanded", found.length > 0);
    this.input.removeAttribute("aria-activedescendant");
  }

  closeChoices() {
    this.offer([]);
  }

  take(field) {
    const at = this.input.selectionStart, text = this.input.value;
    const begin = at - (text.slice(0, at).match(WORD)?.[0].length ?? 0);
    this.input.value = text.slice(0, begin) + field + text.slice(at);
    this.input.setSelectionRange(begin + field.length, begin + field.length);
    this.closeChoices();
    this.look();
  }

  press(event) {
    if (this.choices.hidden) {
      if (event.key === "Escape") this.showApplied();
      return;
    }
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (step) this.highlight((this.chosen + step + this.fields.length) % this.fields.length);
    else if (event.key === "Escape") this.closeChoices();
    else if ((event.key === "Enter" || event.key === "Tab") && this.chosen >= 0) this.take(this.fields[this.chosen]);
    else return;
    event.preventDefault();
  }

  highlight(place) {
    [...this.choices.children].forEach((choice, number) => choice.setAttribute("aria-selected", number === place));
    this.chosen = place;
    this.input.setAttribute("aria-activedescendant", `choice-${place}`);
  }
}
