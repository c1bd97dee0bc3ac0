// SPDX-License-Identifier: GPL-2.0-or-later
// What a person can do with the filter of a field, and the one that is applied: [{words, filter}].

export const asFilters = (applied, filter) => [
  { words: "Filter", title: "Apply as filter", filter },
  ...(applied ? [{ words: "And", title: "And this filter", filter: `(${applied}) && ${filter}` }] : []),
  { words: "Not", title: "Not this", filter: `!(${filter})` },
];
