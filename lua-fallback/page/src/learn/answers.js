// SPDX-License-Identifier: GPL-2.0-or-later
// Compares what was typed with what is accepted, and says what the mistake is.
// A check returns {right, say}: `right` is null where the text cannot be read, and `say` tells why.

import { readHex, readNumber, readPackets, readText, unitOf } from "./reading.js";

const HEXADECIMAL = "That is the number in hexadecimal; a decimal one is asked.";
const REVERSED = "The bytes are in reverse order.";

function wrong(say) {
  return { right: false, say: say || "Not right." };
}

function unreadable(say) {
  return { right: null, say };
}

// The unit that a number without one has: that of the blank, of the answer, or of the prompt ("in rpm").
function askedUnit({ unit, accepted, prompt = "" }) {
  const [, named] = prompt.match(/\bin (\S+)$/) || [];
  const known = named && unitOf(named);
  return unitOf(unit || "") || readNumber(accepted[0])?.unit || (known && !known.unknown ? known : null);
}

const COUNTED = ["a count", "a number of bytes"];

function misunit({ unit }, asked) {
  if (!unit || unit.quantity === asked?.quantity) return null;
  if (unit.unknown) return unreadable(`The unit ${unit.unknown} is not known here.`);
  if (asked) return wrong(`That is ${unit.quantity}; ${asked.quantity} is asked.`);
  return COUNTED.includes(unit.quantity) ? null : unreadable("No unit is asked. Type the number alone.");
}

// Numbers in the smallest unit; a unit counts only where one is asked.
function amounts({ values, unit }, asked) {
  return values.map((value) => value * (asked ? (unit || asked).factor : 1));
}

function quantityOf({ unit }, asked) {
  if (!asked && COUNTED.includes(unit?.quantity)) return "";
  return (unit || asked)?.quantity || "";
}

function sameNumber(typed, accepted, ask) {
  const asked = askedUnit(ask);
  if (quantityOf(typed, asked) !== quantityOf(accepted, asked)) return false;
  const near = asked && !asked.exact ? 0.005 : 1e-9; // a time may be rounded
  const [wanted] = amounts(accepted, asked);
  return amounts(typed, asked).some((value) => Math.abs(value - wanted) <= near * Math.max(Math.abs(value), Math.abs(wanted)));
}

function reversed(value, width) {
  return parseInt(value.toString(16).padStart(2 * width, "0").match(/../g).reverse().join(""), 16);
}

// What is wrong with a number, by the first of these that holds.
const SLIPS = [
  { say: "The digits are right. Look at the unit.", holds: (typed, wanted) => typed.unit && typed.values.includes(wanted) },
  { say: HEXADECIMAL, holds: (typed, wanted) => typed.digits === wanted.toString(16) },
  { say: "The digits are right. Look at the sign.", holds: (typed, wanted) => typed.values.includes(-wanted) },
  { say: "The digits are right. Count the decimal places.", holds: (typed, wanted, amount) => amount.some((value) => {
    const places = Math.log10(Math.abs(value / wanted));
    return Number.isFinite(places) && Math.abs(places - Math.round(places)) < 1e-9;
  }) },
  { say: REVERSED, holds: (typed, wanted) => Number.isInteger(wanted) && wanted > 0 && wanted < 2 ** 32
    && [2, 4].some((width) => wanted < 256 ** width && typed.values.includes(reversed(wanted, width))) },
];

function aboutNumber(typed, accepted, ask) {
  const asked = askedUnit(ask), unfit = misunit(typed, asked);
  if (unfit) return unfit;
  const [value] = amounts(accepted, asked), scale = asked ? asked.factor : 1;
  const wanted = Number((value / scale).toPrecision(12)), amount = amounts(typed, asked).map((one) => one / scale);
  return wrong(SLIPS.find(({ holds }) => holds(typed, wanted, amount))?.say);
}

// Digits such as 1B, which are no decimal number.
function unreadNumber(text, ask) {
  const value = readNumber(ask.accepted[0])?.values[0].toString(16);
  return text.trim().toLowerCase().replace(/^0+(?=.)/, "") === value ? HEXADECIMAL : "Type a number, such as 27, 0x1B or 12 ms.";
}

// A value and the bytes of the line are not the same: accepted words without a blank are values. What is typed in one of
// the two ways is compared with answers of the other one only if there are none of its own.
function sameHex(typed, accepted, ask) {
  const isValue = typed.value !== null;
  if (isValue !== (accepted.value !== null) && ask.accepted.some((one) => (readHex(one)?.value !== null) === isValue)) return false;
  if (isValue && accepted.value !== null) return typed.value === accepted.value;
  return !typed.marked && String(typed.bytes) === String(accepted.bytes);
}

function aboutHex(typed, accepted, ask) {
  const all = ask.accepted.map(readHex), value = all.find((one) => one.value !== null)?.value;
  if (!typed.bytes && !value) return unreadable("A digit is missing or too many. Type each byte with two, such as 02 D9.");
  if (value && typed.value === parseInt(value, 16).toString()) return wrong("That is the number in decimal; a hexadecimal one is asked.");
  const turned = typed.bytes?.length > 1 && String([...typed.bytes].reverse());
  if (all.some(({ bytes }) => String(bytes) === turned)) return wrong(REVERSED);
  return wrong(typed.marked && !value ? "That is written as one value. The bytes in the order of the line are asked." : "");
}

function aboutPackets(typed, accepted) {
  const right = typed.filter((number) => accepted.includes(number)).length;
  return wrong(`${right} right, ${accepted.length - right} missing, ${typed.length - right} too many.`);
}

const identical = (one, other) => String(one) === String(other);
const told = (say) => () => say;

const CHECKS = {
  number: { read: readNumber, same: sameNumber, about: aboutNumber, unread: unreadNumber },
  packets: { read: readPackets, same: identical, about: aboutPackets, unread: told("Type packet numbers, such as 3, 5 or 3-5; or none.") },
  hex: { read: readHex, same: sameHex, about: aboutHex, unread: told("Type bytes in hexadecimal, such as 02 D9.") },
  text: { read: readText, same: identical, about: () => wrong() },
  choice: { read: (text) => text.trim().toLowerCase(), same: identical, about: () => wrong() },
};

function compare(ask, text) {
  const { read, same, about, unread } = CHECKS[ask.kind];
  const typed = read(text);
  const equals = (one, reading = typed) => {
    const known = read(one);
    return reading === null || known === null ? text.trim() === one.trim() : same(reading, known, ask);
  };
  if (ask.accepted.some((one) => equals(one))) return { right: true, say: "Right." };
  // A mistake that is meant by the first reading counts before one of the others: 2.404 is rather two than two thousand.
  const readings = typed && ask.kind === "number" ? typed.values.map((value) => ({ ...typed, values: [value] })) : [typed];
  for (const reading of readings) {
    const mistake = ask.mistakes?.find((one) => equals(one.wrong, reading));
    if (mistake) return wrong(mistake.say);
  }
  if (typed === null) return unreadable(unread(text, ask));
  const accepted = read(ask.accepted[0]);
  return accepted === null ? wrong() : about(typed, accepted, ask);
}

// Two filters are the same if each leaves what the other does. `matched(filter)` asks Wireshark how many packets a filter
// leaves; it throws Wireshark's words if the filter is not valid.
async function compareFilter({ accepted, mistakes = [] }, typed, matched) {
  const shared = async (left, other) => {
    const [wanted, both] = [await matched(other), await matched(`(${typed}) && (${other})`)];
    return { both, same: left === wanted && left === both };
  };
  try {
    const left = await matched(typed), { same, both } = await shared(left, accepted[0]);
    if (same) return { right: true, say: "Right." };
    for (const mistake of mistakes) if ((await shared(left, mistake.wrong)).same) return wrong(mistake.say);
    return wrong(`That leaves ${left} packets, ${both} of them right.`);
  } catch (error) {
    return unreadable(error.message);
  }
}

export async function check(ask, typed, matched) {
  if (!typed.trim()) return unreadable("Type an answer first.");
  return ask.kind === "filter" ? compareFilter(ask, typed, matched) : compare(ask, typed);
}
