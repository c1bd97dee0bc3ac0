// SPDX-License-Identifier: GPL-2.0-or-later
// Reads what people type for an answer: numbers with units, packets, bytes in hexadecimal, words. null: it cannot be read.

// What is measured: how a sentence names it, and its units with their factors.
const QUANTITIES = {
  "a time": { 1: "s sec secs sek sek. second seconds sekunde sekunden", 1e-3: "ms msec msecs millisecond milliseconds millisekunden",
    1e-6: "us usec microsecond microseconds mikrosekunden", 60: "min mins minute minutes minuten" },
  "a speed": { 1: `rpm 1/min /min min-1 min^-1 u/min r/min rev/min umdr/min umdrehungen/min upm
    revperminute revolutionsperminute`, 60: "1/s /s s-1 rps" },
  "a baud rate": { 1: "bd baud bit/s bits/s bps", 1000: "k kbd kbaud kbit/s kbits/s kbps" },
  "a length": { 1: "mm", 10: "cm", 1000: "m", 1e-3: "um", 25.4: "in inch inches" },
  "a percentage": { 1: "% percent prozent" },
  "an angle": { 1: "° deg degree degrees grad" },
  "a frequency": { 1: "hz", 1000: "khz" },
  "a number of bytes": { 1: "byte bytes octet octets b", 0.125: "bit bits" },
  "a count": { 1: `x times mal time axes axis character characters command commands drive drives element elements entries packet packets
    pakete phase phases reaction reactions station stations step steps telegram telegrams telegramme` },
};
const UNITS = new Map(Object.entries(QUANTITIES).flatMap(([quantity, units]) => Object.entries(units).flatMap(([factor, words]) =>
  words.split(/\s+/).map((word) => [word, { quantity, factor: Number(factor), exact: quantity !== "a time", unknown: "" }]))));

const OTHER = /\d|\b(?:or|not|no|oder|nicht)\b/; // what stands behind an answer may be a second one
const ROUGHLY = /^(?:=|~|≈|about|approx\.?|approximately|ca\.?|circa|etwa)\s*/;
const COUNTED = ["zero one two three four five six seven eight nine ten eleven twelve",
  "null ein zwei drei vier fünf sechs sieben acht neun zehn elf zwölf"].map((words) => words.split(" "));
const NAMED = "antrieb|axis|bit|byte|character|drive|element|master|packet|paket|phase|slave|station|telegram|number|nr";
const NOUN = new RegExp(String.raw`^(?:(?:${NAMED})\s+|n[or]\.\s*|#)+(?=\d)`);
const HEXADECIMAL = /^(?:(?:0x|16#|\$)([0-9a-f]+)|([0-9a-f]+) ?h(?:ex)?)(?!\w)(.*)$/;
const UNMARKED = /^\d*[a-f][\da-f]*$/; // 1B may be hexadecimal
const DECIMAL = /^([+-]?) ?(\d{1,3}(?:[ '_]\d{3})+(?![\d ])(?:[.,]\d+)?|\d+(?:[.,]\d+)*|[.,]\d+)(.*)$/;
const ANOTHER = /^[\d.,-]|^ *-? *\d+(?!\/)| (?:to|or|bis|oder) /; // a unit does not look so
const GROUPED = { ",": /^[1-9]\d{0,2}(?:,\d{3})+$/, ".": /^[1-9]\d{0,2}(?:\.\d{3})+$/ };

// Small letters, plain hyphens and quotes, no full stop at the end.
function plain(text) {
  return text.normalize("NFKC").toLowerCase().replace(/[‐-―−]/g, "-").replace(/[‘’´`]/g, "'").replace(/["“”„]/g, "")
    .replace(/μ/g, "u").replace(/\s+/g, " ").trim().replace(/(^|[^.])[.!]$/, "$1");
}

// An unknown unit is a quantity of its own.
export function unitOf(words) {
  const word = plain(words).replace(/ /g, "");
  return word ? UNITS.get(word) || { quantity: `a value in ${word}`, factor: 1, exact: true, unknown: word } : null;
}

// What digits can mean: "2.000" is two, or two thousand in German.
function values(digits) {
  const found = /^\d*[.,]?\d+$/.test(digits) ? [Number(digits.replace(",", "."))] : [];
  for (const [group, point] of [[",", "."], [".", ","]]) {
    const [whole, ...fraction] = digits.split(point);
    if (fraction.length < 2 && GROUPED[group].test(whole)) found.push(Number([whole.replaceAll(group, ""), ...fraction].join(".")));
  }
  return found;
}

// "three", "none", "minus 20" in digits.
function inDigits(words) {
  return words.replace(/^none$/, "0").replace(/^minus /, "-").replace(/^[a-zü]+(?= |$)/, (word) => {
    const value = Math.max(...COUNTED.map((language) => language.indexOf(word)));
    return value < 0 ? word : String(value);
  });
}

function readAlone(text) {
  const words = inDigits(text.replace(ROUGHLY, "").replace(NOUN, "")).replace(/^(\d+)k(\d+)/, "$1.$2k");
  const marked = words.match(HEXADECIMAL);
  if (marked) return { values: [parseInt(marked[1] || marked[2], 16)], unit: unitOf(marked[3]), digits: "" };
  const found = UNMARKED.test(words) ? null : words.match(DECIMAL);
  if (!found || ANOTHER.test(found[3])) return null;
  const sign = found[1] === "-" ? -1 : 1;
  const read = values(found[2].replace(/[ '_]/g, "")).map((value) => sign * value);
  return read.length ? { values: read, unit: unitOf(found[3]), digits: found[2] } : null;
}

// "0,012 s", "2.000 U/min", "0x1B", "1B h", "bit 4", "19k2", "16 (0x10)": {values, unit, digits}, one value for each way to read it.
export function readNumber(text) {
  const [, before, remark] = plain(text).match(/^(.*\S) \(([^()]*)\)$/) || [];
  const number = readAlone(before || plain(text));
  const agrees = !before || !OTHER.test(remark) || String(number?.values) === String(readAlone(remark)?.values);
  return agrees ? number : null;
}

const NO_PACKETS = /^(?:none|none at all|not any|nothing|no|-|keines?|(?:no|keine) (?:packets?|frames?|pakete))$/;
const BESIDE = "packets?|pakete?|pkts?|frames?|telegrams?|numbers?|nos?|nr|from|von|and|und|u|the|plus|also|both|p";
const BESIDE_PACKETS = new RegExp(String.raw`\b(?:${BESIDE})\b\.?|[&,;#+/()[\]{}]`, "g");

// "3, 5", "packets #3 and #5", "3-5", "3 to 5", "none": numbers in order; null where it is no such list.
export function readPackets(text) {
  const words = plain(text);
  if (NO_PACKETS.test(words)) return [];
  const numbers = new Set();
  const ranges = words.replace(BESIDE_PACKETS, " ").replace(/(\d)\s*(?:-|\.{2,3}|to|bis|through)\s*(?=\d)/g, "$1-");
  for (const word of ranges.trim().split(/\s+/)) {
    const found = word.match(/^(\d{1,6})(?:-(\d{1,6}))?$/);
    const [first, last] = found ? [Number(found[1]), Number(found[2] || found[1])] : [0, 0];
    if (first < 1 || last < first) return null;
    for (let number = first; number <= last; number++) numbers.add(number);
  }
  return [...numbers].sort((one, other) => one - other);
}

const HEX_NAMED = /^(?:=|bytes?\b|checksum\b|code\b|error\b|status\b|[[(])\s*|(?:\s*hex|[\])])$/g;

// "0x02, d9", "02:D9", "02D9", "7007h": {bytes, value, marked}. One word is a value, too; bytes are null where digits are missing.
export function readHex(text) {
  const words = plain(text).replace(HEX_NAMED, "").replace(/\\x/g, " ").trim().split(/[\s,;:./-]+/);
  const digits = words.map((word) => word.replace(/^(?:0x|16#|[x$#])|h$/g, ""));
  if (!digits.every((word) => /^[0-9a-f]+$/.test(word))) return null;
  const paired = digits.map((word) => word.padStart(2, "0"));
  const whole = paired.every((word) => word.length % 2 === 0);
  return { bytes: whole ? paired.join("").match(/../g) : null, value: words.length === 1 ? digits[0].replace(/^0+(?=.)/, "") : null,
    marked: digits[0].length > 2 && (words[0] !== digits[0] || /hex\W*$/i.test(text)) };
}

const NO_OTHER = `(?!.*(?:${OTHER.source}))`;
const BEHIND = new RegExp(String.raw` ?\(${NO_OTHER}[^()]*\)$`);
const PARAMETER = new RegExp(String.raw`^([spac])[-._ ]?([\do])(?:(?:[-._ ]|- | -| - )(\d{1,4})|(\d{4}))(?:[,:]? ${NO_OTHER}.*)?$`);
const CODE = /^(?:0x|[$#])?([0-9a-f]{4})h?$/;

// A parameter, a code, or words without what does not matter.
export function readText(text) {
  const words = plain(text).replace(/^(?:(?:the|an?|der|die|das|parameter|code|error|fault) )+/, "").replace(BEHIND, "");
  const [, kind, set, number, joined] = words.match(PARAMETER) || [];
  if (kind) return `${kind}-${set === "o" ? 0 : set}-${(number || joined).padStart(4, "0")}`;
  const code = words.replace(/^([a-z]{1,2})[ -](\d{2,5})$/, "$1$2");
  return /\d/.test(code) ? code.replace(CODE, "$1") : code;
}
