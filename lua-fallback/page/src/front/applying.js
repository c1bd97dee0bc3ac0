// SPDX-License-Identifier: GPL-2.0-or-later
// Filters that a click makes.

// The accesses to a parameter; `station` is its number, or a text where several are meant.
export const ofParameter = (ident, station) => `sis.parameter == "${ident}"${/^\d+$/.test(station) ? ` && sis.station == ${station}` : ""}`;

// What a person can do with the filter of a field, and the one that is applied: [{words, filter}].

export const asFilters = (applied, filter) => [
  { words: "Filter", title: "Apply as filter", filter },
  ...(applied ? [{ words: "And", title: "And this filter", filter: `(${applied}) && ${filter}` }] : []),
  { words: "Not", title: "Not this", filter: `!(${filter})` },
];
