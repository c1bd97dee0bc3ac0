// SPDX-License-Identifier: GPL-2.0-or-later
// What a lesson names is one click away: packets, fields of packets, filters, menus that this page has, too.

import { button, element, find } from "../front/dom.js";

// `opened` opens the capture that the text is about, unless it is open.
export function linkText(text, { capture, showing, applyFilter, opened }) {
  const linked = (code, act, title) => code.replaceWith(button(code.textContent, act, { className: "link code", title }));
  for (const link of text.querySelectorAll("a.packet")) {
    link.addEventListener("click", (event) => {
      event.preventDefault();
      showing(async () => {
        await opened();
        await capture.goTo(Number(link.textContent));
      });
    });
  }
  for (const row of text.querySelectorAll("table.filter.packets tbody tr")) {
    const code = find("code", row), filter = code.textContent;
    linked(code, () => showing(async () => {
      await opened();
      applyFilter(filter, { stays: true });
    }), "Use this filter");
  }
  for (const row of text.querySelectorAll("table.packet.field tbody tr")) {
    const number = Number(row.cells[0].textContent), code = find("code", row), field = code.textContent;
    linked(code, () => showing(async () => {
      await opened();
      await capture.goTo(number);
      capture.dispatchEvent(new CustomEvent("wanted", { detail: field }));
    }), `Show it in packet ${number}`);
  }
  for (const menu of text.querySelectorAll("em.menu")) {
    const { textContent: words } = menu;
    if (/^Statistics > S(IS|ervice)/.test(words)) menu.replaceWith(element("a", { href: "#statistics" }, words));
    else menu.append(" (in Wireshark)");
  }
}
