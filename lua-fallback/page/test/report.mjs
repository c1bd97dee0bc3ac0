// SPDX-License-Identifier: GPL-2.0-or-later
// Follows links of a report in a headless Firefox: node report.mjs FIREFOX PAGE CAPTURE EXPRESSION...
// Prints {values, complaints} as JSON. Each expression is waited for, and its value is printed.

import { Firefox } from "./browser.mjs";

const [path, page, capture, ...expressions] = process.argv.slice(2);
const firefox = await Firefox.start(path);

try {
  await firefox.open(page);
  await firefox.choose(capture);
  const values = [];
  for (const expression of expressions) {
    await firefox.until(expression);
    values.push((await firefox.run(expression)).value);
  }
  process.stdout.write(JSON.stringify({ values, complaints: firefox.complaints }));
} finally {
  await firefox.end();
}
