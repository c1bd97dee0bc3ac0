// SPDX-License-Identifier: GPL-2.0-or-later
// What TypeScript does not know: interfaces of browsers that are not everywhere, and what stands before a worker's script.

declare module "pyodide";
declare module "pyodide/pyodide.asm.mjs";

interface Navigator {
  serial?: any; // Web Serial
}

interface Window {
  importScripts: any; // of a worker
  loadWiregasm: any; // made by wiregasm.js
}

interface Uint8ArrayConstructor {
  fromBase64?(text: string): Uint8Array<ArrayBuffer>;
}

declare function showSaveFilePicker(options: object): Promise<any>;
