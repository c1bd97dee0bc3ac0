// SPDX-License-Identifier: GPL-2.0-or-later
// Opens the page in a headless Firefox, and captures in it: node firefox.mjs FIREFOX PAGE CAPTURE...
// Prints {seconds, rows, hasSerial, complaints} as JSON: how long each took, the first one from the start of the page on.

import { Firefox } from "./browser.mjs";

const [path, page, ...captures] = process.argv.slice(2);
const firefox = await Firefox.start(path);

try {
  const seconds = [], rows = [];
  let begin = performance.now();
  await firefox.open(page);
  for (const capture of captures) {
    await firefox.choose(capture);
    seconds.push((performance.now() - begin) / 1000);
    rows.push((await firefox.run("document.querySelector('.packet-list').ariaRowCount - 1")).value);
    begin = performance.now();
  }
  const hasSerial = (await firefox.run("'serial' in navigator")).value;
  process.stdout.write(JSON.stringify({ seconds, rows, hasSerial, complaints: firefox.complaints }));
} finally {
  await firefox.end();
}
