// SPDX-License-Identifier: GPL-2.0-or-later
// The virtual bus: played at once into a capture, or live, with faults to switch on.

import { element } from "./dom.js";
import { Live } from "./live.js";
import { callTap } from "./tap.js";

const OUT = "bus.pcapng";

// The switches of sistap/commands/web/play.py.
const SWITCHES = {
  late: "Late reactions", silent: "Missing reactions", pause: "Pauses in telegrams", checksum: "Wrong checksums",
  parity: "Parity errors", break: "Breaks", lost: "Lost characters", noise: "Noise",
};

export function playView(capture, { opening, showing }) {
  const select = element("select", { id: "scenario" });
  const seed = element("input", { type: "number", id: "seed", value: 1, min: 0, step: 1 });
  const duration = element("input", { type: "number", id: "duration", value: 60, min: 1, step: 1 });
  const root = element("section", { className: "page", "aria-labelledby": "play-title" },
    element("h1", { id: "play-title" }, "Play a bus"),
    element("p", {}, "A bus in software: masters ask, drives answer, and things go wrong. The same seed plays the same bytes."),
    element("form", { className: "choices-form", onsubmit: (event) => {
      event.preventDefault();
      if (event.submitter?.value === "live") playLive();
      else playAtOnce();
    } },
      element("p", { className: "field-line" }, element("label", { htmlFor: "scenario" }, "Scenario"), select),
      element("p", { className: "field-line" }, element("label", { htmlFor: "seed" }, "Seed"), seed),
      element("p", { className: "field-line" }, element("label", { htmlFor: "duration" }, "Seconds, if it is played at once"), duration),
      element("p", {}, element("button", { type: "submit", value: "live", className: "large" }, "Play live"), " ",
        element("button", { type: "submit", value: "once", className: "large" }, "Play at once"))));

  const playAtOnce = () => opening(async () => {
    const words = ["bus", select.value, "-w", OUT, "--seed", seed.value, "--duration", duration.value];
    const { code, said, written } = await capture.long(`Playing ${select.value}`, (options) => callTap("command", [words, {}, [OUT]], options));
    if (code) throw new Error(said.trim());
    await capture.open(`${select.value}.pcapng`, written[OUT]);
  });

  const playLive = () => showing(async () => {
    await capture.long("Starting sistap", (options) => callTap("play", [select.value, Number(seed.value)], options));
    const [, , hasSwitches] = root.listed.find(([name]) => name === select.value);
    const begun = performance.now();
    location.hash = "#packets";
    await new Live(capture, {
      title: `Playing ${select.value}`,
      name: `${select.value}.pcapng`,
      controls: hasSwitches ? [switches()] : [],
      next: () => callTap("step", [(performance.now() - begun) / 1000]),
    }).run();
  });

  root.enter = () => root.listed || showing(async () => {
    root.listed = await capture.long("Starting sistap", (options) => callTap("scenarios", [], options));
    select.replaceChildren(...root.listed.map(([name, title]) => element("option", { value: name, selected: name === "demo" }, `${name}: ${title}`)));
  });
  return root;
}

// Faults that act while they are ticked.
function switches() {
  return element("details", { className: "switches" }, element("summary", {}, "Faults"),
    ...Object.entries(SWITCHES).map(([kind, words]) => element("label", {},
      element("input", { type: "checkbox", onchange: ({ target }) => callTap("switch", [kind, target.checked]) }), ` ${words}`)));
}
