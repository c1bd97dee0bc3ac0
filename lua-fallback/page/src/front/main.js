// SPDX-License-Identifier: GPL-2.0-or-later
// Puts the page together: its views, and which one is seen. The part after # in the address names it.

import { Stopped } from "../protocol.js";
import { Answer } from "./answer.js";
import { Bytes } from "./bytes.js";
import { Capture } from "./capture.js";
import { changesView } from "./changes.js";
import { compareView } from "./compare.js";
import { learnView } from "../learn/learn.js";
import { curveView } from "./curve.js";
import { about, askImport, askLimits, askPattern } from "./dialogs.js";
import { button, element, find, findAll } from "./dom.js";
import { exportDialog } from "./export.js";
import { rememberFilters } from "./history.js";
import { importBytes, openBytes, openPasted, refuseTooLarge, visible } from "./files.js";
import { FilterBar } from "./filter.js";
import { findingsView } from "./findings.js";
import { folded } from "./folded.js";
import { followView, streamOf } from "./follow.js";
import { Lanes } from "./lanes.js";
import { PacketList } from "./list.js";
import { listenView } from "./listen.js";
import { LogLines } from "./log.js";
import { leftView } from "./left.js";
import { keepParts } from "./parts.js";
import { menusOf } from "./menus.js";
import { playView } from "./play.js";
import { readProfile } from "./profile.js";
import { remarksOf } from "./remarks.js";
import { reportView } from "./report.js";
import { splitter } from "./splitter.js";
import { startView, takeDrops } from "./start.js";
import { statisticsView } from "./statistics.js";
import { Tree } from "./tree.js";

const capture = new Capture();
const views = {};
let shown = ""; // the name of the view that is seen

const PAGES = { open: "Open", listen: "Listen", play: "Play", learn: "Learn" };
const OF_CAPTURE = { answer: "Answer", packets: "Packets", findings: "Findings", statistics: "Statistics", curve: "Curve", changes: "Changes", report: "Report",
  compare: "Compare" };

function trouble(error) {
  find("#trouble").textContent = error ? error.message ?? String(error) : "";
}

// Does something, and says what is wrong if it fails.
async function showing(work) {
  trouble("");
  try {
    await work();
  } catch (error) {
    if (!(error instanceof Stopped)) trouble(error);
  }
}

const opening = (work, { stays = false } = {}) => showing(async () => {
  await capture.live?.stop();
  try {
    await work();
    if (!stays) location.hash = "#packets";
  } catch (error) {
    if (error.import) importOtherwise(error.message, error.import);
    else if (error.log) askPattern(error.message, (pattern) => opening(() => openBytes(capture, error.log.name, error.log.bytes, { pattern })));
    else throw error;
  }
});

const importOtherwise = (message, { name, bytes, told }) =>
  askImport(message, told, (typed) => opening(() => importBytes(capture, name, bytes, typed)));

// One capture is open at a time.
const openFiles = ([file, ...others]) => file && opening(async () => {
  const name = visible(file.name);
  refuseTooLarge(file);
  await openBytes(capture, name, new Uint8Array(await file.arrayBuffer()));
  if (others.length) capture.note(`Only ${name} is open. Compare takes a second one.`);
});

const goTo = (number) => showing(async () => {
  location.hash = "#packets";
  await capture.goTo(number);
});

const applyFilter = (filter, { stays = false } = {}) => showing(async () => {
  if (!stays) location.hash = "#packets";
  await capture.setFilter(filter);
});

const reopen = (preferences) => {
  if (shown !== "learn") capture.kept = preferences;
  const { name, bytes, log, imported, filter, number } = capture;
  return opening(async () => {
    await capture.open(name, bytes, { log, imported, filter, number, preferences });
    views[shown].enter?.();
  }, { stays: true });
};

const tellLimits = () => askLimits(capture, reopen);

function packetsView(profile, answer) {
  const filter = new FilterBar(capture, profile.buttons);
  const list = new PacketList(capture, profile, { onsort: (sort) => showing(() => capture.sortBy(sort)) });
  const lanes = new Lanes(capture, { goTo, showing }, list, profile.rules);
  const tree = new Tree(capture, { onfilter: (text) => filter.apply(text) });
  const bytes = new Bytes(capture);
  menusOf(capture, { list, tree, bytes }, (text) => filter.apply(text));
  const log = new LogLines(capture);
  const exporting = exportDialog(capture, profile.columns, { showing });
  const follow = button("Follow", () => {
    location.hash = "#follow";
    views.follow.begin(streamOf(capture.packet));
  }, { title: "All telegrams of the two stations of this packet" });
  capture.addEventListener("selected", () => (follow.disabled = streamOf(capture.packet) === undefined));
  const exportButton = button("Export", exporting.open);
  for (const event of ["busy", "opened", "grown", "closed"]) capture.addEventListener(event, () => (exportButton.disabled = !capture.isOpen));
  filter.acts.append(follow, button("Limits", tellLimits), exportButton);
  const logPane = element("div", { className: "pane log-pane", hidden: true }, log.root);
  const below = element("div", { className: "below" }, element("div", { className: "pane" }, tree.root, tree.said),
    element("div", { className: "pane" }, bytes.root), logPane);
  const notes = element("div", { className: "notes" });
  const again = () => importOtherwise(capture.imported.said.join(" "), { name: capture.name, ...capture.imported });
  const showNotes = () => notes.replaceChildren(...remarksOf(capture, again));
  capture.addEventListener("noted", showNotes);
  for (const event of ["opened", "grown"]) {
    capture.addEventListener(event, () => {
      logPane.hidden = !capture.log;
      below.classList.toggle("with-log", Boolean(capture.log));
      showNotes();
      if (capture.log) log.begin();
    });
  }
  return element("section", { className: "packets", "aria-label": "Packets" },
    element("h1", { className: "visually-hidden" }, "Packets"), folded(answer.bar, "what happened"), filter.root,
    folded(notes, "notes"), lanes.root, list.root, splitter(list.root), below, exporting.root);
}

// A lesson remembers what it has to. If a person has done nothing yet, the browser would complain.
const isAtStake = () => capture.isOpen && shown !== "learn" && navigator.userActivation?.hasBeenActive !== false;

function showBusy() {
  const { busy } = capture;
  const holder = find("#busy");
  holder.hidden = !busy;
  if (!busy) return holder.replaceChildren();
  if (holder.busy !== busy) {
    holder.busy = busy;
    holder.replaceChildren(element("span", {}, busy.words), element("progress", { max: 1, "aria-label": busy.words }), button("Cancel", busy.cancel));
  }
  if (busy.part) find("progress", holder).value = busy.part;
  return undefined;
}

function route() {
  const asked = location.hash.slice(1).split("/")[0];
  const name = Object.hasOwn(views, asked) && (capture.isOpen || Object.hasOwn(PAGES, asked)) ? asked : "open";
  if (name !== shown) views[shown]?.leave?.();
  shown = name;
  if (name !== "learn") find("#main").append(views.packets); // a lesson has it beside its text
  for (const [other, view] of Object.entries(views)) view.hidden = other !== name;
  for (const link of findAll("nav a")) {
    if (link.hash === `#${name}`) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  views[name].enter?.();
}

const links = (names) => Object.entries(names).map(([name, words]) => element("a", { href: `#${name}` }, words));

async function begin() {
  const profile = await readProfile();
  const acts = { goTo, applyFilter, opening, showing, tellLimits };
  const answer = new Answer(capture, acts);
  const packets = packetsView(profile, answer);
  Object.assign(views, {
    open: startView({ left: leftView(capture, acts), openFiles, openPasted: (text) => opening(() => openPasted(capture, text)) }),
    listen: listenView(capture, acts),
    play: playView(capture, acts),
    learn: learnView(capture, packets, acts),
    answer: answer.root,
    packets,
    findings: findingsView(capture, acts),
    statistics: statisticsView(capture, acts),
    curve: curveView(capture, profile, acts),
    changes: changesView(capture, acts),
    report: reportView(capture, acts),
    compare: compareView(capture, acts),
    follow: followView(capture, acts),
  });
  find("#main").append(...Object.values(views));
  find("#pages").append(...links(PAGES));
  find("#of-capture").append(...links(OF_CAPTURE));
  find("#top").append(button("About", about));
  takeDrops(openFiles);
  capture.addEventListener("busy", showBusy);
  for (const event of ["opened", "grown"]) {
    capture.addEventListener(event, () => {
      find("#open-name").textContent = capture.name;
      find("#of-capture").hidden = false;
      document.title = `${capture.name} - SIS`;
      if (event === "grown" && location.hash === "#packets" && views.packets.hidden) route();
    });
  }
  capture.addEventListener("closed", () => {
    find("#of-capture").hidden = true;
    route();
  });
  addEventListener("beforeunload", (event) => (capture.live || isAtStake()) && event.preventDefault()); // the browser asks
  rememberFilters(capture, showing);
  addEventListener("hashchange", () => {
    trouble(""); // it was about the view before
    route();
  });
  route();
  await capture.viewer;
  document.documentElement.dataset.ready = "true";
  keepParts();
}

begin().catch(trouble);
