// SPDX-License-Identifier: GPL-2.0-or-later
// Captures that were heard and never ended, because the page was closed or the browser has ended: to open, save, delete.

import { button, element, save } from "./dom.js";
import { InStorage } from "./keeping.js";
import { openWhole } from "./live.js";

export function leftView(capture, { opening, showing }) {
  const root = element("div", {});
  const renew = async () => root.replaceChildren(...(await InStorage.left().catch(() => [])).map(one));

  const open = (kept) => opening(async () => {
    const said = await openWhole(capture, kept.name, await kept.whole());
    if (said) throw new Error(said); // there is nothing else to be seen
  });

  function one(kept) {
    return element("div", { className: "left" },
      element("p", {}, element("b", {}, kept.name), ": the page was closed while it listened. What came until then is kept in this browser."),
      element("p", {}, button("Open", () => open(kept)), " ",
        button("Save", () => showing(async () => save(kept.name, await kept.whole()))), " ",
        button("Delete", () => showing(async () => {
          await kept.drop();
          await renew();
        }))));
  }

  renew();
  return root;
}
