// SPDX-License-Identifier: GPL-2.0-or-later
// What the rules of Wireshark's profile that colour the packet list say of a packet. The four for what is as it should be
// have a kind each. All others, also those that the profile gets, are of faults.

const CALM = { "SIS: command": "command", "SIS: reaction": "reaction", "Serial tap: other characters": "other", "Serial tap: event": "event" };

export const kindOf = ({ name }) => CALM[name] ?? "fault";

// Returns a function that tells whether a row of a colour is of a fault.
export function faultsBy(rules) {
  const calm = new Set(rules.filter((rule) => kindOf(rule) !== "fault").map(({ paper }) => paper));
  return (paper) => paper !== "" && !calm.has(paper);
}
