// SPDX-License-Identifier: GPL-2.0-or-later
// What the colour of a rule of Wireshark's profile means for a row. The profile has calm colours, blue to green and grey,
// for what is as it should be: commands, reactions, events, other characters. All others are of faults: red, orange,
// yellow and purple. So a rule that the profile gets is judged, too.

const CALM = { from: 140, to: 245 }; // degrees of hue: green to blue
const GREY = 0.1; // least saturation of a colour

export function isFault(paper) {
  if (!paper) return false;
  const [red, green, blue] = paper.match(/[0-9a-f]{2}/gi).map((digits) => parseInt(digits, 16) / 255);
  const most = Math.max(red, green, blue), range = most - Math.min(red, green, blue);
  if (range < GREY * most) return false;
  const sextant = { [blue]: 4 + (red - green) / range, [green]: 2 + (blue - red) / range, [red]: (6 + (green - blue) / range) % 6 }[most];
  return sextant * 60 < CALM.from || sextant * 60 > CALM.to;
}
