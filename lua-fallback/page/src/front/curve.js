// SPDX-License-Identifier: GPL-2.0-or-later
// A numeric field over the time of the capture, from Wireshark's I/O graphs: its least, mean and greatest value in each
// step.

import { asCsv } from "./csv.js";
import { CurvePicture } from "./curvepicture.js";
import { button, element, plural, save } from "./dom.js";
import { firstOf } from "./items.js";
import { rounded } from "./ticks.js";
import { Zoom, follow, pressed } from "./zoom.js";

const STEPS = 900; // in the width of the picture
const MOST = 200_000; // steps of the whole capture, when a part is measured
const KINDS = ["max", "min", "avg", "frames"];
const RELATIVE_TIME = 25; // Wireshark's number of a type: its values are in s
const HELP = "Wheel: zoom. Drag: move. Double click: all. Click a value, or use the arrow keys and Enter, to go to its packet.";

export function curveView(capture, profile, { goTo, showing }) {
  const graphs = profile.graphs.filter(({ field }) => field !== "sis");
  const select = element("select", { id: "curve-graph", onchange: () => {
    input.value = graphs[select.value]?.field ?? "";
    root.enter();
  } }, ...graphs.map(({ name }, place) => element("option", { value: place }, name)), element("option", { value: "" }, "Another field"));
  const input = element("input", { type: "text", id: "curve-field", value: graphs[0].field, spellcheck: false });
  const curve = new Curve(capture, { goTo, showing });
  const root = element("section", { className: "page", "aria-labelledby": "curve-title" },
    element("h1", { id: "curve-title" }, "Curve"),
    element("form", { className: "form-line", onsubmit: (event) => {
      event.preventDefault();
      root.enter();
    } }, element("label", { htmlFor: "curve-graph" }, "Show"), select, element("label", { htmlFor: "curve-field" }, "Field"), input,
      element("button", { type: "submit" }, "Draw")),
    curve.root, curve.said, curve.acts);
  root.enter = () => showing(() => curve.begin(input.value.trim(), graphs[select.value]));
  root.show = (field) => {
    const place = graphs.findIndex((graph) => graph.field === field);
    select.value = place < 0 ? "" : place;
    input.value = field;
  };
  capture.addEventListener("opened", () => curve.clear());
  return root;
}

class Curve {
  constructor(capture, { goTo, showing }) {
    this.capture = capture;
    this.goTo = goTo;
    this.showing = showing;
    this.root = element("div", { className: "picture" });
    this.said = element("p", { className: "curve-said", role: "status" });
    this.acts = element("p", { className: "form-line" });
    this.zoom = new Zoom(() => this.redraw());
    new ResizeObserver(() => this.redraw()).observe(this.root);
  }

  clear() {
    this.picture = null;
    for (const part of [this.root, this.said, this.acts]) part.replaceChildren();
  }

  async begin(field, graph) {
    if (!field) throw new Error("Type the name of a field, such as sis.value.number");
    const filter = graph?.field === field ? `(${graph.filter}) && ${field}` : field;
    if (this.picture && this.filter === filter && this.field === field) return; // who comes back finds it as it was
    this.field = field;
    this.filter = filter;
    this.title = graph?.field === field ? graph.name : field;
    this.zoom.setWhole(0, Math.max(this.capture.seconds, 0.001));
    await this.measure(0, this.zoom.last);
  }

  // Measures a part of the time, and draws it.
  async measure(from, to) {
    const { capture, field, filter } = this;
    const unit = await this.unit();
    const stepMs = Math.max(1, Math.ceil(Math.max(((to - from) * 1000) / STEPS, (capture.seconds * 1000) / MOST)));
    const isAll = from === 0 && to === this.zoom.last;
    const wanted = { interval: String(stepMs) };
    KINDS.forEach((kind, place) => {
      wanted[`graph${place}`] = `${kind}:${field}`;
      wanted[`filter${place}`] = isAll ? filter : `${filter} && frame.time_relative >= ${from} && frame.time_relative < ${to}`;
    });
    const [most, least, mean, counts] = await capture.graph(wanted);
    const value = (number) => rounded(number * unit.factor);
    const points = counts.map((count, place) => ({ count, time: (place * stepMs) / 1000, most: value(most[place]), least: value(least[place]), mean: value(mean[place]) }))
      .filter(({ count }) => count > 0);
    this.draw({ points, step: stepMs / 1000, unit: unit.name, isAll });
  }

  // Times are drawn in ms. The unit of a value is that of its parameter, if the first packet tells it.
  async unit() {
    const viewer = await this.capture.viewer;
    const found = (await viewer.call("completions", [this.field])).find(({ field }) => field === this.field);
    if (found?.type === RELATIVE_TIME) return { name: "ms", factor: 1000 };
    if (this.field.endsWith(".ms")) return { name: "ms", factor: 1 };
    if (!/^sis[.]value/.test(this.field) || !/sis[.]parameter ==/.test(this.filter)) return { name: "", factor: 1 };
    const { rows: [first] } = await viewer.call("rows", [this.filter, 0, 1]);
    const item = first && firstOf((await viewer.call("packet", [first.number])).tree, "sis.parameter.unit");
    return { name: item?.filter.match(/"(.*)"/)?.[1] ?? "", factor: 1 };
  }

  draw({ points, step, unit, isAll }) {
    const { field, root, said, acts, zoom, title } = this;
    this.clear();
    said.textContent = points.length ? `${plural(points.length, "value or range", "values or ranges")} of ${field}${unit && ` in ${unit}`}. ${HELP}` : `No packet has ${field}.`;
    if (!points.length) return;
    const isStepped = field.startsWith("sis.value");
    this.picture = new CurvePicture({ points, step, zoom, isStepped, title: title.endsWith(unit) || !unit ? title : `${title} [${unit}]` });
    const { svg } = this.picture;
    follow(svg, zoom, { part: (event) => this.picture.part(event), onclick: (event) => this.go(this.choose(this.picture.nearest(event))) });
    svg.addEventListener("pointermove", (event) => event.buttons || this.choose(this.picture.nearest(event)));
    svg.addEventListener("keydown", (event) => this.press(event));
    root.replaceChildren(svg);
    this.finer = button("Measure this part more exactly", () => this.showing(() => this.measure(zoom.from, zoom.to)), { hidden: true });
    const whole = button("Measure all again", () => this.showing(() => {
      zoom.all();
      return this.measure(0, zoom.last);
    }), { hidden: isAll });
    acts.replaceChildren(button("Save as CSV", () => save(`${field}.csv`, csvOf(field, points, unit), "text/csv")), this.finer, whole);
    this.redraw();
  }

  redraw() {
    if (!this.picture || !this.root.clientWidth) return;
    this.picture.draw(this.root.clientWidth);
    this.finer.hidden = this.zoom.span > (this.picture.step * STEPS) / 2 || this.picture.step <= 0.001;
  }

  choose(place) {
    const { picture, said, zoom } = this;
    const { time, most, least, count } = picture.choose(place);
    if (time < zoom.from - picture.step || time > zoom.to) zoom.show(time - zoom.span / 2, time + zoom.span / 2);
    said.textContent = `${time} s: ${most > least ? `${least} to ${most}` : most} (${plural(count, "packet")})`;
    return picture.chosen;
  }

  async go(place) {
    const { field, capture, picture: { points, step } } = this, { time } = points[place];
    const filter = `${field} && frame.time_relative >= ${time} && frame.time_relative < ${time + step}`;
    const { rows } = await (await capture.viewer).call("rows", [filter, 0, 1]);
    if (rows.length) this.goTo(rows[0].number);
  }

  press(event) {
    const { picture, zoom } = this, { chosen, points } = picture;
    const next = event.shiftKey ? undefined : { ArrowRight: chosen + 1, ArrowLeft: chosen - 1, Home: 0, End: points.length - 1 }[event.key];
    if (next !== undefined) this.choose(next);
    else if (event.key === "Enter" && chosen >= 0) this.go(chosen);
    else if (!pressed(zoom, event)) return;
    event.preventDefault();
  }
}

const csvOf = (field, points, unit) => asCsv([["time in s", "packets", ...["least", "mean", "greatest"].map((which) => `${which} ${field}${unit && ` in ${unit}`}`)],
  ...points.map(({ time, count, least, mean, most }) => [time, count, least, mean, most].map(String))]);
