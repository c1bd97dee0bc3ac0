// SPDX-License-Identifier: GPL-2.0-or-later
// Shows the packets of the capture, the fields of the one that is selected, and its bytes.

const list = document.querySelector("#packet-list tbody");
const details = document.getElementById("packet-details");
const shownBytes = document.getElementById("packet-bytes");
const filterText = document.getElementById("filter-text");
const filterSaid = document.getElementById("filter-said");
const rows = new Map();
let selected = null; // the packet
let marks = []; // elements of its bytes, by source
let opened = new Set(); // labels of items that the reader has opened

function element(name, properties, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

function fillList() {
  for (const packet of PAGE.packets) {
    const [time, from, to, words] = packet.columns;
    const cells = [packet.number, Number(time).toFixed(4), from, to, words];
    const row = element("tr", { id: `packet-${packet.number}`, tabIndex: -1, className: `rule${packet.style}` },
      ...cells.map((text) => element("td", { textContent: text })));
    row.addEventListener("click", () => select(packet.number, true));
    rows.set(packet.number, row);
    list.append(row);
  }
  list.addEventListener("keydown", (event) => {
    const visible = PAGE.packets.filter((packet) => !rows.get(packet.number).hidden);
    const at = visible.indexOf(selected);
    const next = { ArrowDown: at + 1, ArrowUp: at - 1, Home: 0, End: visible.length - 1 }[event.key];
    if (next === undefined) return;
    event.preventDefault();
    if (visible[next]) select(visible[next].number, true);
  });
}

function select(number, focus) {
  const packet = PAGE.packets.find((one) => one.number === number);
  if (!packet) return false;
  if (selected) {
    rows.get(selected.number).setAttribute("aria-selected", "false");
    rows.get(selected.number).tabIndex = -1;
  }
  selected = packet;
  const row = rows.get(number);
  row.hidden = false;
  row.setAttribute("aria-selected", "true");
  row.tabIndex = 0;
  if (focus) row.focus({ preventScroll: true });
  showBytes(packet);
  details.replaceChildren(...packet.tree.map((item, at) => branch(item, packet.tree.length - at)));
  uncover(row);
  return true;
}

// A long capture is not in the page as a whole.
function goToPacket(number, focus) {
  if (!select(number, focus)) filterSaid.textContent = `Packet ${number} is not in this page. Open the capture in Wireshark.`;
}

// Scrolls the list, and nothing else, until a row is in sight.
function uncover(row) {
  const box = row.closest(".list");
  const [top, height] = [row.offsetTop - list.offsetTop, row.offsetHeight];
  if (top < box.scrollTop || top + 3 * height > box.scrollTop + box.clientHeight) box.scrollTop = top - height;
}

// Opens the innermost layers: of the tap only where nothing else is in the packet.
function branch(item, layers) {
  const [label, first, size, source, filter, below, other] = item;
  const mark = () => markBytes(first, size, source);
  if (!below.length) {
    const leaf = element("button", { type: "button", textContent: label, title: filter });
    leaf.addEventListener("click", mark);
    leaf.addEventListener("focus", mark);
    if (other) leadTo(leaf, other);
    leaf.item = item;
    return leaf;
  }
  const name = label.replace(/[:,].*/, "");
  const summary = element("summary", { textContent: label, title: filter });
  summary.item = item;
  summary.addEventListener("click", mark);
  const folded = element("details", { open: opened.has(name) || layers === 1 || (layers && !label.startsWith("Serial tap")) }, summary,
    ...below.map((one) => branch(one, 0)));
  folded.addEventListener("toggle", () => (folded.open ? opened.add(name) : opened.delete(name)));
  return folded;
}

// As in Wireshark, a double click on the number of a packet goes there.
function leadTo(leaf, number) {
  leaf.title += ` (double click or Enter: go to packet ${number})`;
  leaf.addEventListener("dblclick", () => goToPacket(number, true));
  leaf.addEventListener("keydown", (event) => {
    if (event.key !== "Enter") return;
    event.preventDefault();
    goToPacket(number, true);
  });
}

function showBytes(packet) {
  const sources = [["", packet.bytes], ...packet.others];
  marks = [];
  shownBytes.replaceChildren();
  sources.forEach(([name, digits], source) => {
    if (name) shownBytes.append(element("p", { textContent: name }));
    marks.push(hexLines(shownBytes, digits, source ? [] : packet.kinds, (at) => markField(at, source)));
  });
  if (!packet.bytes) shownBytes.append(element("p", { textContent: "No characters: a note of the tap." }));
}

// Lines of bytes with their text; returns the elements of the bytes.
function hexLines(parent, digits, kinds, click) {
  const wide = window.innerWidth < 500 ? 8 : 16;
  const made = [];
  for (let first = 0; first < digits.length / 2; first += wide) {
    const line = element("div", { className: "line" });
    let text = "";
    for (let at = first; at < Math.min(first + wide, digits.length / 2); at++) {
      const pair = digits.substr(2 * at, 2).toUpperCase();
      const code = parseInt(pair, 16);
      text += code >= 0x20 && code < 0x7f ? String.fromCharCode(code) : "·";
      const byte = element("b", { textContent: pair, className: kinds[at] || "" });
      byte.addEventListener("click", () => click(at));
      made.push(byte);
      line.append(byte);
    }
    line.append(element("i", { textContent: text }));
    parent.append(line);
  }
  return made;
}

function markBytes(first, size, source) {
  marks.forEach((bytes, number) => bytes.forEach((byte, at) => {
    byte.classList.toggle("marked", number === source && at >= first && at < first + size);
  }));
}

// Finds the smallest field that holds a byte, and goes there.
function markField(at, source) {
  const fields = [...details.querySelectorAll("button, summary")].filter(({ item }) =>
    item[3] === source && item[1] <= at && at < item[1] + item[2] && !item[4].startsWith("sertap."));
  const field = fields.reduce((best, one) => (best && best.item[2] < one.item[2] ? best : one), null);
  if (field) goTo(field);
}

function goTo(field) {
  for (let above = field.parentElement.closest("details"); above; above = above.parentElement.closest("details")) {
    above.open = true;
  }
  field.focus();
  markBytes(field.item[1], field.item[2], field.item[3]);
}

function showField(name) {
  const field = [...details.querySelectorAll("button, summary")].find(({ item }) => item[4].split(" ")[0] === name);
  if (field) goTo(field);
}

function applyFilter(expression) {
  filterText.value = expression;
  const left = packetsOf(expression);
  if (left === null) {
    filterSaid.textContent =
      "This page cannot run that filter: it knows those of the lesson, and fields with their values. In Wireshark you can.";
    return;
  }
  for (const [number, row] of rows) row.hidden = !left.includes(number);
  filterSaid.textContent = expression.trim() ? `Leaves ${listed(left)}.` : "";
  const first = PAGE.packets.find((packet) => left.includes(packet.number));
  if (first && (!selected || !left.includes(selected.number))) select(first.number);
}

function fillFilters() {
  const buttons = document.getElementById("filter-buttons");
  for (const [word, filter, help] of PAGE.buttons) {
    const button = element("button", { type: "button", textContent: word, title: `${help}: ${filter}` });
    button.addEventListener("click", () => applyFilter(filter));
    buttons.append(button, " ");
  }
  document.getElementById("filter").addEventListener("submit", (event) => {
    event.preventDefault();
    applyFilter(filterText.value);
  });
  document.getElementById("filter-clear").addEventListener("click", () => applyFilter(""));
}

// Where the packets do not stand beside the text, goes to them.
function look() {
  const panel = document.querySelector("aside");
  if (getComputedStyle(panel).position !== "sticky") panel.scrollIntoView();
}

// What the lesson names is one click away: packets, fields of packets, filters.
function linkText() {
  for (const link of document.querySelectorAll("a.packet")) {
    link.addEventListener("click", (event) => {
      event.preventDefault();
      goToPacket(Number(link.textContent));
      look();
    });
  }
  for (const row of document.querySelectorAll("table.filter.packets tbody tr")) {
    const code = row.cells[0].querySelector("code");
    const button = element("button", { type: "button", className: "try", title: "Apply this filter" }, code);
    button.addEventListener("click", () => {
      applyFilter(code.textContent);
      look();
    });
    row.cells[0].append(button);
  }
  for (const row of document.querySelectorAll("table.packet.field tbody tr")) {
    const [number, code] = [Number(row.cells[0].textContent), row.cells[1].querySelector("code")];
    const button = element("button", { type: "button", className: "try", title: `Show it in packet ${number}` }, code);
    button.addEventListener("click", () => {
      goToPacket(number);
      look();
      showField(code.textContent);
    });
    row.cells[1].append(button);
  }
}
