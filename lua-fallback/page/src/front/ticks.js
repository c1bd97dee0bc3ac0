// SPDX-License-Identifier: GPL-2.0-or-later
// Numbers for an axis.

// Returns round numbers from `low` to `high`, about `count` of them.
export function ticks(low, high, count) {
  const raw = (high - low) / Math.max(count, 1) || 1, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((candidate) => candidate >= raw * (1 - 1e-9));
  const first = Math.ceil(low / step);
  return Array.from({ length: Math.floor(high / step) - first + 1 }, (_, place) => Number(((first + place) * step).toPrecision(12)));
}

export const rounded = (value) => Number(value.toPrecision(6));
