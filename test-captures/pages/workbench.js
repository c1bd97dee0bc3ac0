// SPDX-License-Identifier: GPL-2.0-or-later
// Takes a telegram apart while it is typed, by the tables in the page.

const BENCH = JSON.parse(document.getElementById("data").textContent).workbench;
const HEADER = 8; // bytes that are always there
const CHECKSUM = 1, LENGTH = 2, REPEAT = 3, CONTROL = 4, SERVICE = 5;
const hexOf = (value, digits = 2) => value.toString(16).toUpperCase().padStart(digits, "0");
const little = (bytes) => bytes.reduceRight((sum, byte) => sum * 256 + byte, 0);

function named(table, code) {
  const found = table.find(([first, last]) => first <= code && code <= last);
  return found ? found[2] : "no such code in the documents";
}

function parameter([kind, low, high]) {
  const word = low + 256 * high;
  const letter = kind === 0 ? (word & 0x8000 ? "P" : "S") : { 1: "A", 2: "C" }[kind] || `type${kind}`;
  return `${letter}-${(word >> 12) & 7}-${String(word & 0xfff).padStart(4, "0")}`;
}

const MEANINGS = {
  number: (bytes) => String(little(bytes)),
  parameter,
  "parameter control": ([byte]) =>
    `${named(BENCH.tables.elements, (byte >> 3) & 7)}, ${byte & 4 ? "last transmission" : "more follows"}`,
  data(bytes) {
    const text = bytes.every((byte) => byte >= 0x20 && byte < 0x7f) ? `"${String.fromCharCode(...bytes)}"` : "";
    const number = [1, 2, 4].includes(bytes.length) ? `low byte first: ${little(bytes)}` : "";
    return [`${bytes.length} ${bytes.length === 1 ? "byte" : "bytes"}`, number, text].filter(Boolean).join(", ");
  },
};

const TIMES = { 1: "TrS", 2: "TzA", 3: "Tmas" };

// The fields of a telegram: {first, size, name, meaning, kind, bad}.
function fieldsOf(bytes) {
  const fields = [];
  let at = 0;
  const add = (name, size, kind, meaning, bad = false) => {
    const part = bytes.slice(at, at + size);
    fields.push({ first: at, size: part.length, name, kind, bad, meaning: meaning(part) });
    at += part.length;
    return part;
  };
  BENCH.header.forEach(([name, kind], place) => {
    if (place < bytes.length) add(name, 1, kind, ([byte]) => headerMeaning(place, byte, bytes), headerIsBad(place, bytes));
  });
  if (bytes.length < HEADER) return fields;
  const control = bytes[CONTROL];
  for (let number = 1; number <= (control & 7) && at < bytes.length; number++) {
    add(`Subaddress ${number}`, 1, "address", ([byte]) => `${byte}, ${named(BENCH.addresses, byte)}`);
  }
  if (control & 8 && at < bytes.length) add("Telegram number", 1, "control", ([byte]) => String(byte));
  addBody(bytes, Boolean(control & 16), () => bytes.length - at, add);
  return fields;
}

function headerIsBad(place, bytes) {
  if (place === 0) return bytes[0] !== 2;
  if (place === CHECKSUM) return sumOf(bytes) !== 0;
  if (place === LENGTH || place === REPEAT) return bytes[place] !== bytes.length - HEADER;
  return false;
}

function headerMeaning(place, byte, bytes) {
  if (place === 0) return byte === 2 ? "good" : "must be 02";
  if (place === CHECKSUM) {
    return sumOf(bytes) === 0 ? "good: all bytes together end in 00" : `must be ${hexOf(rightChecksum(bytes))}`;
  }
  if (place === LENGTH || place === REPEAT) {
    const there = bytes.length - HEADER;
    return `${byte}: ${byte === there ? "good, so many bytes follow the first eight" : `must be ${there}, if this is all`}`;
  }
  if (place === CONTROL) return controlMeaning(byte);
  if (place === SERVICE) return named(BENCH.tables.services, byte);
  return `${byte}, ${named(BENCH.addresses, byte)}`;
}

function controlMeaning(byte) {
  const said = [byte & 16 ? "reaction" : "command", `${byte & 7} subaddresses`];
  for (const [bits, words] of BENCH.control) {
    if (!["0-2", "4"].includes(bits) && byte & (1 << Number(bits))) said.push(`bit ${bits}: ${words}`);
  }
  return said.join("; ");
}

function addBody(bytes, reaction, left, add) {
  const body = BENCH.bodies[bytes[SERVICE]];
  let layout = body ? body.command : null;
  if (reaction && left()) {
    const [status] = add("Status", 1, "status", ([byte]) =>
      byte === 2 && body && body["2"] && body["2"][0][0] === "Phase" ? "Phase switching error"
        : named(BENCH.tables.status, byte));
    layout = body && (status === 0 ? body.good : status >= 0xf0 ? body.head : body[String(status)]);
  }
  let subservice = null;
  for (const [name, size, meaning] of layout || []) {
    if (!left()) return;
    if (meaning === "data" && bytes[SERVICE] === 3 && subservice !== null && !reaction) addSetting(subservice, left, add);
    if (!left()) return;
    const part = add(name, size || left(), kindOf(name), (found) => meaningOf(meaning, found, subservice));
    if (name === "Subservice") subservice = part[0];
  }
  if (left()) add(layout ? "Too much" : "Useful data", left(), "data", MEANINGS.data);
}

// A subservice of the initialization, as far as its data are a time.
function addSetting(subservice, left, add) {
  if ((subservice in TIMES || subservice === 8) && left() >= 2) {
    add(TIMES[subservice] || "Test time", 2, "data", (found) => `${little(found)} ms`);
  }
}

function meaningOf(meaning, found, subservice) {
  if (MEANINGS[meaning]) return MEANINGS[meaning](found);
  const wide = found.length === 1 && meaning.startsWith("errors_"); // subservice and error byte together are the code
  const code = wide ? 256 * subservice + found[0] : little(found);
  return `${hexOf(code, wide ? 4 : 2 * found.length)}: ${named(BENCH.tables[meaning], code)}`;
}

function kindOf(name) {
  if (/error|status/i.test(name)) return "status";
  if (/ervice/.test(name)) return "service";
  return /^(Device|Parameter|List)/.test(name) ? "object" : "data";
}

const sumOf = (bytes) => bytes.reduce((sum, byte) => sum + byte, 0) % 256;
const rightChecksum = (bytes) => (256 - ((sumOf(bytes) - bytes[CHECKSUM] + 256) % 256)) % 256;

function benchBytes(text) {
  const words = text.replace(/0x|\\x/gi, " ").replace(/[\s,;:.-]+/g, " ").trim();
  const digits = words.split(" ").map((word) => (word.length === 1 ? "0" + word : word)).join("");
  if (!/^([0-9a-f]{2})*$/i.test(digits)) return null;
  return (digits.match(/../g) || []).map((pair) => parseInt(pair, 16));
}

function startWorkbench() {
  const input = document.getElementById("bench-text");
  const said = document.getElementById("bench-said");
  const body = document.querySelector("#bench-fields tbody");
  const shown = document.getElementById("bench-bytes");

  function show() {
    const bytes = benchBytes(input.value);
    body.replaceChildren();
    shown.replaceChildren();
    if (bytes === null) {
      said.textContent = "Bytes have two hexadecimal digits each, such as 02 D9.";
      return;
    }
    for (const field of fieldsOf(bytes)) {
      const pairs = bytes.slice(field.first, field.first + field.size).map((byte) => hexOf(byte)).join(" ");
      const row = body.insertRow();
      row.className = field.bad ? "bad" : "";
      for (const text of [pairs, field.name, field.meaning]) row.insertCell().textContent = text;
      row.cells[0].classList.add(field.kind);
      const mark = document.createElement("b");
      mark.textContent = pairs;
      mark.title = field.name;
      mark.className = field.kind;
      shown.append(mark, " ");
    }
    const sum = bytes.reduce((all, byte) => all + byte, 0);
    const missing = bytes.length < HEADER ? `; a telegram has at least ${HEADER}` : "";
    said.textContent = `${bytes.length} bytes${missing}. Their sum is ${hexOf(sum)} in hexadecimal.`;
  }

  function change(set) {
    const bytes = benchBytes(input.value);
    if (!bytes || bytes.length < HEADER) return;
    set(bytes);
    input.value = bytes.map((byte) => hexOf(byte)).join(" ");
    show();
  }

  input.addEventListener("input", show);
  document.getElementById("bench-checksum").addEventListener("click", () => change((bytes) => {
    bytes[CHECKSUM] = rightChecksum(bytes);
  }));
  document.getElementById("bench-length").addEventListener("click", () => change((bytes) => {
    bytes[LENGTH] = bytes[REPEAT] = bytes.length - HEADER;
  }));
  show();
}

startWorkbench();
