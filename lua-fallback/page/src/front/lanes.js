// SPDX-License-Identifier: GPL-2.0-or-later
// The first picture of a capture, above its packets: a lane for each station, time to the right. The second Wireshark
// finds what is drawn; capture.found, the report, gives the bands behind it.

import { Stopped } from "../protocol.js";
import { button, element, plural } from "./dom.js";
import { LABELS, LanePicture } from "./lanepicture.js";
import { Records } from "./records.js";
import { recall, remember } from "./storage.js";
import { Zoom, follow, pressed } from "./zoom.js";

const AT_ONCE = 20_000; // packets of a capture that is drawn without being asked
const IDLE_MS = 3000; // after so long it begins even if the page is not idle
const NEAR = 8; // pixels between a pointer and what it means
const FOLDED = "sis.lanes.folded"; // in the browser's storage
const HELP = "Wheel: zoom. Drag, or Shift and wheel: move. Click: go to the packet. Keys: arrows, + and -, 0 for all, Enter for the packet in the middle.";

export class Lanes {
  // `list` is the packet list, whose visible part is marked; `rules` are those of the profile.
  constructor(capture, { goTo, showing }, list, rules) {
    this.rules = rules;
    this.capture = capture;
    this.goTo = goTo;
    this.showing = showing;
    this.list = list;
    this.records = null;
    this.isDue = false; // what is open is still to be drawn
    this.zoom = new Zoom(() => this.redraw());
    this.canvas = element("canvas", { className: "lanes-canvas", role: "application", tabIndex: 0, title: HELP, hidden: true,
      onkeydown: (event) => this.press(event), onpointermove: (event) => this.tell(event), onpointerleave: () => (this.tip.hidden = true) });
    this.said = element("span", { className: "lanes-said", role: "status" });
    this.key = element("span", { className: "lanes-keys" }, ...legend());
    this.tools = element("span", { className: "lanes-tools" }, button("+", () => this.zoom.by(0.5), { "aria-label": "Zoom in" }), button("−", () => this.zoom.by(2), { "aria-label": "Zoom out" }),
      button("All", () => this.zoom.all(), { "aria-label": "Show all of the time" }));
    this.fold = button("Lanes", () => this.toggle(), { className: "lanes-fold", title: "One line for each station, time to the right" });
    this.tip = element("div", { className: "lanes-tip", hidden: true });
    this.scroller = element("div", { className: "lanes-scroller" }, this.canvas);
    this.root = element("div", { className: "lanes", hidden: true }, element("div", { className: "lanes-head" }, this.fold, this.said, this.key, this.tools), this.scroller, this.tip);
    this.setFolded(recall(FOLDED) === true);
    this.watch();
  }

  watch() {
    const { capture, list, canvas } = this;
    capture.addEventListener("opened", () => this.begin());
    for (const event of ["grown", "closed"]) capture.addEventListener(event, () => this.forget());
    for (const event of ["judged", "filtered", "rows"]) capture.addEventListener(event, () => this.redraw());
    capture.addEventListener("selected", () => this.follow());
    list.root.addEventListener("scroll", () => this.redraw());
    follow(canvas, this.zoom, { part: (event) => this.part(event), onclick: (event) => this.click(event) });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.redraw());
    new ResizeObserver(() => this.appear()).observe(this.root);
  }

  forget() {
    this.records = null;
    this.isDue = false;
    this.root.hidden = this.canvas.hidden = this.tip.hidden = true;
    this.said.replaceChildren();
  }

  begin() {
    this.forget();
    this.root.hidden = false;
    this.isDue = true;
    this.appear();
  }

  // Begins when the strip is seen: in a lesson it is not.
  appear() {
    if (!this.root.offsetWidth || this.isFolded) return;
    if (this.records) this.redraw();
    if (!this.isDue) return;
    this.isDue = false;
    const { packets, bytes } = this.capture;
    if (packets > AT_ONCE) this.offer();
    else whenIdle(() => bytes === this.capture.bytes && this.readAside());
  }

  offer() {
    const work = () => this.showing(() => this.capture.long("Drawing the lanes", (options) => this.read(options)));
    this.said.replaceChildren(button(`Draw ${plural(this.capture.packets, "packet")}`, work));
  }

  // Reads while a person already reads. Who cancels other figures ends it.
  async readAside() {
    this.said.replaceChildren("Drawing ...");
    try {
      await this.read({ signal: new AbortController().signal, progress: (part) => this.said.replaceChildren(`Drawing ... ${Math.round(100 * part)} %`) });
    } catch (error) {
      if (!this.said.textContent.startsWith("Drawing")) return; // another capture is open
      if (error instanceof Stopped) this.offer();
      else this.said.replaceChildren(error.message);
    }
  }

  async read(options) {
    const { bytes } = this.capture;
    const peer = await this.capture.counting(options);
    const noted = await peer.call("lanes", [], { progress: options.progress });
    if (bytes !== this.capture.bytes) return;
    const records = (this.records = new Records(this.rules, noted));
    this.zoom.setWhole(records.first, records.last);
    this.picture = new LanePicture(this.canvas, records, this.zoom);
    this.canvas.setAttribute("aria-label", `Lanes over time. ${HELP} ${summary(records).join(" ")}`);
    this.canvas.hidden = false;
    this.redraw();
  }

  // Moves to the selected packet, if that is beside what is seen.
  follow() {
    const { records, zoom } = this, place = records?.placeOf(this.capture.number) ?? -1;
    if (place < 0) return;
    const time = records.times[place];
    if (time < zoom.from || time > zoom.to) zoom.show(time - zoom.span / 2, time + zoom.span / 2);
    this.redraw();
  }

  // Draws before the browser shows its next picture.
  redraw() {
    if (!this.records || this.isFolded || this.isDrawing) return;
    this.isDrawing = true;
    requestAnimationFrame(() => {
      this.isDrawing = false;
      if (this.records && this.root.offsetWidth) this.draw();
    });
  }

  draw() {
    const { records, zoom, capture, picture, scroller } = this;
    picture.draw({ width: scroller.clientWidth, selected: capture.number, episodes: capture.found?.episodes ?? [],
      began: capture.found?.began_epoch_s ?? 0, seen: this.seen() });
    const part = zoom.isAll ? `${plural(records.numbers.length, "packet")}, ${plural(records.faults, "fault")}, ${records.silences} without a reaction`
      : `${picture.seconds(zoom.from)} to ${picture.seconds(zoom.to)}`;
    if (this.said.textContent !== part) this.said.replaceChildren(part);
  }

  // The numbers of the first and of the last packet that the list shows, of those that it has.
  seen() {
    const { first, seen } = this.list, { capture } = this;
    const end = Math.min(first + seen, capture.matched) - 1;
    if (!capture.filter) return [first + 1, end + 1];
    const [one, other] = [capture.row(first), capture.row(end)];
    return one && other ? [one.number, other.number] : null;
  }

  part(event) {
    const box = this.canvas.getBoundingClientRect();
    return (event.clientX - box.left - LABELS) / (box.width - LABELS);
  }

  // The record that a pointer means: in its lane, or else in any; -1 if there is none.
  meant(event, most = NEAR) {
    const { picture, records, zoom } = this;
    const time = zoom.at(this.part(event)), near = most * picture.perPixel;
    const lane = picture.laneAt(event.clientY - this.canvas.getBoundingClientRect().top);
    const own = lane ? records.nearest(lane.places, time, near) : -1;
    const silence = lane ? records.nearest(lane.silences, time, near) : -1;
    return { lane, time, own, silence };
  }

  click(event) {
    const { own, silence, time } = this.meant(event);
    this.go(own < 0 ? silence : own, time);
  }

  go(place, time) {
    const { records } = this;
    const found = place < 0 ? records.nearest(records.all, time, Infinity) : place;
    if (found >= 0) this.goTo(records.numbers[found]);
  }

  press(event) {
    if (event.key === "Enter") this.go(-1, this.zoom.at(0.5));
    else if (!pressed(this.zoom, event)) return;
    event.preventDefault();
  }

  // Says in a box what is below the pointer.
  tell(event) {
    const { picture, records, tip, root } = this;
    const { lane, time, own, silence } = this.meant(event, NEAR / 2);
    const texts = [...[own, silence].filter((place) => place >= 0).map((place) =>
      `${picture.seconds(records.times[place])}: packet ${records.numbers[place]}, ${records.words(place)}`),
    ...picture.bandsAt(time, lane).map(({ severity, text }) => `${severity}: ${text}`)];
    tip.hidden = !texts.length || event.buttons > 0;
    if (tip.hidden) return;
    tip.replaceChildren(...[...(lane ? [element("b", {}, lane.name)] : []), ...texts].map((text) => element("div", {}, text)));
    const box = root.getBoundingClientRect();
    tip.style.left = `${Math.max(0, Math.min(event.clientX - box.left + 12, box.width - tip.offsetWidth - 4))}px`;
    tip.style.top = `${event.clientY - box.top + 16}px`;
  }

  toggle() {
    this.setFolded(!this.isFolded);
    remember(FOLDED, this.isFolded);
    this.appear();
  }

  setFolded(isFolded) {
    this.isFolded = isFolded;
    this.root.classList.toggle("lanes-folded", isFolded);
    this.fold.setAttribute("aria-expanded", !isFolded);
  }
}

const whenIdle = (work) => (globalThis.requestIdleCallback ? requestIdleCallback(work, { timeout: IDLE_MS }) : setTimeout(work, IDLE_MS / 10));

const legend = () => [["command", "command"], ["reaction", "reaction"], ["fault", "fault"], ["silence", "no reaction"]].map(([kind, words]) =>
  element("span", { className: "lanes-key" }, element("i", { className: `lanes-${kind}` }), words));

// Texts for who does not see the picture.
const summary = ({ lanes }) => lanes.map(({ name, places, faults, silences }) =>
  `${name}: ${plural(places.length, "packet")}, ${plural(faults, "fault")}, ${silences.length} without a reaction.`);
