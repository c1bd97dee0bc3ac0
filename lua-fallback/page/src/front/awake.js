// SPDX-License-Identifier: GPL-2.0-or-later
// Keeps the computer awake. A browser ends that when the page is hidden, so the page asks again when it is seen.

// Returns a function that lets it sleep again.
export function keepAwake() {
  let lock = null;
  const ask = async () => {
    if (document.visibilityState === "visible") lock = await navigator.wakeLock?.request("screen").catch(() => null);
  };
  ask();
  document.addEventListener("visibilitychange", ask);
  return () => {
    document.removeEventListener("visibilitychange", ask);
    lock?.release();
  };
}
