// SPDX-License-Identifier: GPL-2.0-or-later
// Compares what was typed with what is accepted. Forgives blanks, case, 0x, commas and units.
// A check returns {right, say}: `right` is null where the text cannot be read, and `say` tells why.

const UNITS = {
  sec: "s", second: "s", seconds: "s", sekunden: "s",
  msec: "ms", msecs: "ms", millisecond: "ms", milliseconds: "ms", millisekunden: "ms",
  usec: "us", microsecond: "us", microseconds: "us",
};
const NOUN = /^(bit|byte|character|drive|element|master|packet|phase|slave|station|telegram) +(?=\d)/;
const SECONDS = { s: 1, ms: 1e-3, us: 1e-6, "µs": 1e-6 };

function wrong(say) {
  return { right: false, say: say || "Not right." };
}

function unreadable(say) {
  return { right: null, say };
}

// "0,012 s", "12 ms", "0x1B", "1B h", "bit 4", "1350 1/min": the value and its unit; null where it is no number.
function readNumber(text) {
  const found = text.trim().toLowerCase().replace(NOUN, "").replace(/^[.,](?=\d)/, "0.")
    .replace(/\.$/, "")
    .match(/^(?:0x([0-9a-f]+)|([0-9a-f]+) ?h|([+-]?\d+(?:[.,]\d+)?))\s*(s|%|(?:1|[a-zµ]+)\/[a-z]+|[a-zµ]{2,}|)$/);
  if (!found) return null;
  const [, hexadecimal, marked, decimal, unit] = found;
  const value = decimal ? Number(decimal.replace(",", ".")) : parseInt(hexadecimal || marked, 16);
  return { value, unit: UNITS[unit] || unit };
}

function sameNumber(typed, accepted) {
  let [one, other] = [typed.value, accepted.value];
  if (typed.unit in SECONDS && accepted.unit in SECONDS) {
    one *= SECONDS[typed.unit];
    other *= SECONDS[accepted.unit];
  } else if (accepted.unit in SECONDS && typed.unit) {
    return false;
  }
  const near = accepted.unit in SECONDS ? 0.005 : 1e-9; // a time may be rounded
  return Math.abs(one - other) <= near * Math.max(Math.abs(one), Math.abs(other));
}

// "3, 5", "packets 3 and 5", "3-5", "none": numbers in order; null where it is no such list.
function readPackets(text) {
  const words = text.toLowerCase().replace(/packets?|nos?\.|and|und|[&,;#+/]/g, " ").replace(/\.\s*$/, "").trim();
  if (/^(none|no|nothing|-)$/.test(words)) return [];
  const numbers = new Set();
  for (const word of words.replace(/\s*(-|–|\.\.|to|bis)\s*/g, "-").split(/\s+/)) {
    const found = word.match(/^(\d{1,6})(?:-(\d{1,6}))?$/);
    if (!found) return null;
    const [first, last] = [Number(found[1]), Number(found[2] || found[1])];
    for (let number = first; number <= last; number++) numbers.add(number);
  }
  return [...numbers].sort((one, other) => one - other);
}

// "0x02, d9", "02:D9", "02D9": digits alone; null where they are no bytes.
function readHex(text) {
  const words = text.trim().toLowerCase().split(/[\s,;:.-]+/).map((word) => word.replace(/^0x|^\\x|h$/g, ""));
  const digits = words.map((word) => word.padStart(2, "0")).join("");
  return /^([0-9a-f]{2})+$/.test(digits) ? digits : null;
}

function readText(text) {
  return text.toLowerCase().replace(/["'“”`]/g, "").replace(/\s+/g, " ").trim().replace(/[.!]+$/, "");
}

function compareBy(read, same, say) {
  return (typed, accepted) => {
    const value = read(typed);
    if (value === null) return unreadable(say);
    return accepted.some((one) => same(value, read(one))) ? { right: true, say: "Right." } : wrong();
  };
}

const identical = (one, other) => String(one) === String(other);

const CHECKS = {
  number: compareBy(readNumber, sameNumber, "Type a number, such as 27, 0x1B or 12 ms."),
  packets: compareBy(readPackets, identical, "Type packet numbers, such as 3, 5 or 3-5; or none."),
  hex: compareBy(readHex, identical, "Type bytes in hexadecimal, such as 02 D9."),
  text: compareBy(readText, identical, ""),
  choice: compareBy(readText, identical, ""),
};

// Two filters are the same if each leaves what the other does. `matched(filter)` asks Wireshark how many packets a filter
// leaves; it throws Wireshark's words if the filter is not valid.
async function sameFilter(typed, accepted, matched) {
  try {
    const [left, wanted, both] = [await matched(typed), await matched(accepted), await matched(`(${typed}) && (${accepted})`)];
    return left === wanted && left === both ? { right: true, say: "Right." } : wrong(`That leaves ${left} packets, ${both} of them right.`);
  } catch (error) {
    return unreadable(error.message);
  }
}

export async function check(ask, typed, matched) {
  if (!typed.trim()) return unreadable("Type an answer first.");
  return ask.kind === "filter" ? sameFilter(typed, ask.accepted[0], matched) : CHECKS[ask.kind](typed, ask.accepted);
}
