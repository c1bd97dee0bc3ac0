// SPDX-License-Identifier: GPL-2.0-or-later
// Rows in the order of a column: numbers by what they are worth, the rest as words. What is empty is last.

const words = new Intl.Collator("en", { numeric: true });

export function sorted(rows, column, isDown) {
  const keyed = rows.map((row) => ({ row, text: row.cells[column], value: Number(row.cells[column] || NaN) }));
  const turn = isDown ? -1 : 1;
  return keyed.sort((one, other) => Number(one.text === "") - Number(other.text === "") || turn * compared(one, other)).map(({ row }) => row);
}

function compared(one, other) {
  const areNumbers = [one, other].map(({ value }) => !Number.isNaN(value));
  if (areNumbers[0] && areNumbers[1]) return one.value - other.value;
  return Number(areNumbers[1]) - Number(areNumbers[0]) || words.compare(one.text, other.text);
}
