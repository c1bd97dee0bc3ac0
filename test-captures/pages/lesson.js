// SPDX-License-Identifier: GPL-2.0-or-later
// Starts the page of a lesson: its questions, its packets, its progress.

function askedIn(section) {
  const number = section.id.replace("question-", "");
  return PAGE.asks[number].map((ask, place) => ({ ask, name: `ask-${number}-${place}` }));
}

function startQuestion(section) {
  const number = section.id.replace("question-", "");
  const form = section.querySelector("form");
  const verdict = section.querySelector(".verdict");
  const answer = section.querySelector("details.answer");
  for (const { name } of askedIn(section)) {
    const text = typedIn(PAGE.lesson)[name];
    if (typeof text === "string") form.elements[name].value = text;
  }
  form.addEventListener("input", ({ target }) => noteTyped(PAGE.lesson, target.name, target.value));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const results = askedIn(section).map(({ ask, name }) => {
      const field = form.elements[name];
      const result = check(ask, field.value);
      const said = document.getElementById(`${name}-said`);
      said.textContent = result.say;
      said.className = `said ${result.right === null ? "unread" : result.right ? "right" : "wrong"}`;
      return result.right;
    });
    const right = results.every((result) => result === true);
    const parts = results.filter((result) => result === true).length;
    verdict.className = `verdict ${right ? "right" : "wrong"}`;
    verdict.textContent = right ? "Right. The answer below says why." :
      results.length > 1 ? `${parts} of ${results.length} right. Try again, or open the hint.` : "Try again, or open the hint.";
    if (!right) return;
    note(PAGE.lesson, number, "right");
    answer.open = true;
    showProgress();
  });
  answer.addEventListener("toggle", () => {
    if (answer.open) note(PAGE.lesson, number, "shown");
    showProgress();
  });
}

function showProgress() {
  const count = Object.keys(PAGE.asks).length;
  const right = rightOnes(PAGE.lesson);
  document.getElementById("progress").textContent =
    `${right} of ${count} questions answered.${storage ? "" : ` ${NOT_KEPT}`}`;
  for (const [question, how] of Object.entries(answered(PAGE.lesson))) {
    const section = document.getElementById(`question-${question}`);
    if (section) section.classList.toggle("done", how === "right");
  }
  for (const link of document.querySelectorAll('nav a[href^="index.html"]:not([href$="glossary"])')) {
    link.href = `index.html#${encodeURIComponent(PAGE.lesson)}=${encodeURIComponent(JSON.stringify(answered(PAGE.lesson)))}`;
  }
}

function toFragment() {
  const found = window.location.hash.match(/^#packet-(\d+)$/);
  if (found) goToPacket(Number(found[1]));
}

fillList();
fillFilters();
linkText();
document.querySelectorAll(".question").forEach(startQuestion);
if (PAGE.packets.length < PAGE.count) {
  filterSaid.textContent = `The capture has ${PAGE.count} packets. Here are ${PAGE.packets.length} that the lesson names.`;
}
if (PAGE.packets.length) select(PAGE.packets[0].number);
toFragment();
window.addEventListener("hashchange", toFragment);
showProgress();
