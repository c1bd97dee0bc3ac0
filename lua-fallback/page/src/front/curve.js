// SPDX-License-Identifier: GPL-2.0-or-later
// A numeric field over the time of the capture, from Wireshark's I/O graphs: its least and greatest value in each step.

import { asCsv } from "./csv.js";
import { button, element, save } from "./dom.js";
import { shape } from "./svg.js";

const STEPS = 900; // in the width of the picture
const WIDTH = 960, HEIGHT = 380, LEFT = 70, RIGHT = 12, TOP = 12, BOTTOM = 40;

const round = (value) => Number(value.toPrecision(6));

// Round numbers from `low` to `high`, about `count` of them.
export function ticks(low, high, count) {
  const raw = (high - low) / count || 1, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((candidate) => candidate >= raw);
  return Array.from({ length: Math.floor(high / step) - Math.ceil(low / step) + 1 }, (_, place) => round((Math.ceil(low / step) + place) * step));
}

export function curveView(capture, profile, { goTo, showing }) {
  const graphs = profile.graphs.filter(({ field }) => field !== "sis");
  const select = element("select", { id: "curve-graph", onchange: () => {
    input.value = graphs[select.value]?.field ?? "";
    root.enter();
  } }, ...graphs.map(({ name }, place) => element("option", { value: place }, name)), element("option", { value: "" }, "Another field"));
  const input = element("input", { type: "text", id: "curve-field", value: graphs[0].field, spellcheck: false });
  const picture = element("div", { className: "picture" });
  const said = element("p", { className: "curve-said", role: "status" });
  const root = element("section", { className: "page", "aria-labelledby": "curve-title" },
    element("h1", { id: "curve-title" }, "Curve"),
    element("form", { className: "form-line", onsubmit: (event) => {
      event.preventDefault();
      root.enter();
    } }, element("label", { htmlFor: "curve-graph" }, "Show"), select, element("label", { htmlFor: "curve-field" }, "Field"), input,
      element("button", { type: "submit" }, "Draw")),
    picture, said);
  root.enter = () => showing(async () => {
    const { field, steps, stepMs, points } = await measured(capture, input.value.trim(), graphs[select.value]);
    picture.replaceChildren(...(points.length ? [draw({ field, steps, stepMs, points, capture, goTo, said })] : []));
    said.textContent = points.length ? `${points.length} values or ranges of ${field}. Click one, or use the arrow keys and Enter, to go to its packet.`
      : `No packet has ${field}.`;
    if (points.length) said.append(" ", button("Save as CSV", () => save(`${field}.csv`, csvOf(field, points), "text/csv")));
  });
  root.show = (field) => {
    const place = graphs.findIndex((graph) => graph.field === field);
    select.value = place < 0 ? "" : place;
    input.value = field;
  };
  capture.addEventListener("opened", () => {
    picture.replaceChildren();
    said.textContent = "";
  });
  return root;
}

async function measured(capture, field, graph) {
  if (!field) throw new Error("Type the name of a field, such as sis.value.number");
  const stepMs = Math.max(1, Math.ceil((capture.seconds * 1000) / STEPS));
  const filter = graph?.field === field ? `(${graph.filter}) && ${field}` : field;
  const wanted = { interval: String(stepMs) };
  ["max", "min", "frames"].forEach((kind, place) => {
    wanted[`graph${place}`] = `${kind}:${field}`;
    wanted[`filter${place}`] = filter;
  });
  const [most, least, counts] = await capture.graph(wanted);
  const points = counts.map((count, place) => ({ count, time: (place * stepMs) / 1000, most: round(most[place]), least: round(least[place]) }))
    .filter(({ count }) => count > 0);
  return { field, stepMs, steps: counts.length, points };
}

const csvOf = (field, points) => asCsv([["time in s", "packets", `least ${field}`, `greatest ${field}`],
  ...points.map(({ time, count, least, most }) => [time, count, least, most].map(String))]);

function draw({ field, stepMs, points, capture, goTo, said }) {
  const end = Math.max(capture.seconds, 0.001);
  let low = Math.min(...points.map(({ least }) => least)), high = Math.max(...points.map(({ most }) => most));
  if (low === high) [low, high] = [low - Math.abs(low) / 10 - 1e-9, high + Math.abs(high) / 10 + 1e-9];
  const x = (time) => LEFT + (time / end) * (WIDTH - LEFT - RIGHT);
  const y = (value) => HEIGHT - BOTTOM - ((value - low) / (high - low)) * (HEIGHT - TOP - BOTTOM);
  const svg = shape("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: "curve", role: "img", tabindex: 0,
    "aria-label": `${field} over time, from ${low} to ${high}` });
  for (const value of ticks(low, high, 6)) {
    svg.append(shape("line", { x1: LEFT, x2: WIDTH - RIGHT, y1: y(value), y2: y(value), class: "grid" }),
      shape("text", { x: LEFT - 6, y: y(value) + 4, "text-anchor": "end" }, String(value)));
  }
  for (const time of ticks(0, end, 8)) {
    svg.append(shape("line", { x1: x(time), x2: x(time), y1: TOP, y2: HEIGHT - BOTTOM, class: "grid" }),
      shape("text", { x: x(time), y: HEIGHT - BOTTOM + 18, "text-anchor": "middle" }, String(time)));
  }
  svg.append(shape("text", { x: (WIDTH + LEFT) / 2, y: HEIGHT - 4, "text-anchor": "middle" }, "seconds since the first packet"));
  for (const { time, least, most } of points) {
    const at = x(Math.min(time + stepMs / 2000, end));
    if (most > least) svg.append(shape("line", { x1: at, x2: at, y1: y(most), y2: y(least), class: "range" }));
    svg.append(shape("circle", { cx: at, cy: y(most), r: 2.6, class: "value" }));
  }
  const cursor = shape("circle", { r: 6, class: "cursor", visibility: "hidden" });
  svg.append(cursor);
  let place = -1;
  const choose = (next) => {
    place = Math.min(Math.max(next, 0), points.length - 1);
    const { time, most, least, count } = points[place];
    cursor.setAttribute("cx", x(Math.min(time + stepMs / 2000, end)));
    cursor.setAttribute("cy", y(most));
    cursor.setAttribute("visibility", "visible");
    said.textContent = `${time} s: ${most > least ? `${least} to ${most}` : most} (${count === 1 ? "1 packet" : `${count} packets`})`;
  };
  const go = async () => {
    const { time } = points[place];
    const filter = `${field} && frame.time_relative >= ${time} && frame.time_relative < ${time + stepMs / 1000}`;
    const { rows } = await (await capture.viewer).call("rows", [filter, 0, 1]);
    if (rows.length) goTo(rows[0].number);
  };
  const nearest = (event) => {
    const box = svg.getBoundingClientRect(), time = (((event.clientX - box.left) / box.width) * WIDTH - LEFT) / (WIDTH - LEFT - RIGHT) * end;
    const gaps = points.map((point) => Math.abs(point.time - time));
    return gaps.indexOf(Math.min(...gaps));
  };
  svg.addEventListener("pointermove", (event) => choose(nearest(event)));
  svg.addEventListener("click", (event) => {
    choose(nearest(event));
    go();
  });
  svg.addEventListener("keydown", (event) => {
    const next = { ArrowRight: place + 1, ArrowLeft: place - 1, Home: 0, End: points.length - 1 }[event.key];
    if (next !== undefined) choose(next);
    else if (event.key === "Enter" && place >= 0) go();
    else return;
    event.preventDefault();
  });
  return svg;
}
