// SPDX-License-Identifier: GPL-2.0-or-later
// Pyodide tries to import a script, and starts only where that fails. The page's policy would refuse it, with a message.
self.importScripts = () => {
  throw new Error("this worker imports nothing");
};
