// SPDX-License-Identifier: GPL-2.0-or-later
// Shows the progress of all lessons.

function takeFromLink() {
  const found = window.location.hash.match(/^#([^=]+)=(.+)$/);
  if (!found) return;
  const lesson = decodeURIComponent(found[1]);
  if (![...document.querySelectorAll("progress")].some((bar) => bar.dataset.lesson === lesson)) return;
  try {
    for (const [question, how] of Object.entries(JSON.parse(decodeURIComponent(found[2])))) {
      if (/^\d+$/.test(question) && (how === "right" || how === "shown")) note(lesson, question, how);
    }
  } catch {
    return; // a link that somebody has cut
  }
}

function showAll() {
  let [right, count] = [0, 0];
  for (const bar of document.querySelectorAll("progress")) {
    bar.value = rightOnes(bar.dataset.lesson);
    bar.parentElement.querySelector(".count").textContent = `${bar.value} of ${bar.max}`;
    right += bar.value;
    count += bar.max;
  }
  document.getElementById("progress").textContent =
    `${right} of ${count} questions answered.${storage ? "" : ` ${NOT_KEPT}`}`;
}

document.getElementById("forget").addEventListener("click", () => {
  forget();
  showAll();
});
takeFromLink();
showAll();
