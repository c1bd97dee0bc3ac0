// SPDX-License-Identifier: GPL-2.0-or-later
// Knows which packets a display filter leaves: tshark has run those in the page, and this combines them by and, or, not.

const PAGE = JSON.parse(document.getElementById("data").textContent);
const WORDS = { and: "&&", or: "||", not: "!", eq: "==", ne: "!=", gt: ">", lt: "<", ge: ">=", le: "<=" };
const RELATIONS = { "==": (one, other) => one === other, "!=": (one, other) => one !== other,
  "<": (one, other) => one < other, ">": (one, other) => one > other,
  "<=": (one, other) => one <= other, ">=": (one, other) => one >= other };
const TOKEN = /\s*("(?:[^"\\]|\\.)*"|&&|\|\||[=!<>]=|[!<>(){}]|[^\s"&|=!<>(){}]+|[&|=])/y;

function tokens(text) {
  const found = [];
  const rest = text.trim();
  TOKEN.lastIndex = 0;
  while (TOKEN.lastIndex < rest.length) {
    const match = TOKEN.exec(rest);
    if (!match) return null;
    found.push(plain(match[1]));
  }
  return found;
}

// The same for what means the same: words for signs, decimal for hexadecimal.
function plain(token) {
  if (token.startsWith('"')) return token;
  const word = token.toLowerCase().replace(/,$/, "");
  if (word in WORDS) return WORDS[word];
  if (/^0x[0-9a-f]+$/.test(word)) return String(parseInt(word, 16));
  if (/^-?\d+(\.\d+)?$/.test(word)) return String(Number(word));
  if (word === "true" || word === "false") return word === "true" ? "1" : "0";
  return word;
}

const KNOWN = new Map();
for (const [expression, left] of Object.entries(PAGE.filters || {})) KNOWN.set(tokens(expression).join(" "), left);

// The numbers of the packets that a filter leaves; null where this page does not know.
function packetsOf(expression) {
  const words = tokens(expression);
  if (words === null) return null;
  const whole = Array.from({ length: PAGE.count }, (_, at) => at + 1);
  if (!words.length) return whole;
  let at = 0;

  function either() {
    let left = both();
    while (left && words[at] === "||") {
      at++;
      const more = both();
      left = more && whole.filter((number) => left.includes(number) || more.includes(number));
    }
    return left;
  }

  function both() {
    let left = single();
    while (left && words[at] === "&&") {
      at++;
      const more = single();
      left = more && left.filter((number) => more.includes(number));
    }
    return left;
  }

  function single() {
    if (words[at] === "!") {
      at++;
      const left = single();
      return left && whole.filter((number) => !left.includes(number));
    }
    if (words[at] === "(") {
      at++;
      const left = either();
      return words[at++] === ")" ? left : null;
    }
    const first = at;
    while (at < words.length && !["&&", "||", ")"].includes(words[at])) at++;
    return atom(words.slice(first, at));
  }

  function atom(said) {
    const [field, relation, value] = said;
    if (said.length === 3 && field === "frame.number" && relation in RELATIONS) {
      return whole.filter((number) => RELATIONS[relation](number, Number(value)));
    }
    if (relation === "in" && value === "{" && said[said.length - 1] === "}") return anyOf(field, said.slice(3, -1));
    return KNOWN.get(said.join(" ")) || null;
  }

  function anyOf(field, values) {
    const left = values.map((value) => KNOWN.get(`${field} == ${value}`));
    return left.every(Boolean) ? whole.filter((number) => left.some((one) => one.includes(number))) : null;
  }

  const direct = KNOWN.get(words.join(" "));
  if (direct) return direct;
  const left = either();
  return at === words.length ? left : null;
}

function listed(packets) {
  if (!packets.length) return "no packet";
  const shown = packets.slice(0, 30).join(", ") + (packets.length > 30 ? ", ..." : "");
  return (packets.length === 1 ? "packet " : "packets ") + shown;
}
