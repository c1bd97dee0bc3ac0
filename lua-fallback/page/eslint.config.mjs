// SPDX-License-Identifier: GPL-2.0-or-later
// What ESLint checks in the scripts of the page. A test runs it: test_page_style.py. NPM names the folder of packages.

import { createRequire } from "node:module";
import { join } from "node:path";

const js = createRequire(join(process.env.NPM, "package.json"))("@eslint/js");

// Names that the browser, a worker or node defines.
const BROWSER = `
  AbortController Blob CSS CustomEvent DOMException DOMParser DecompressionStream Event EventTarget Image MutationObserver ReadableStream Request
  ResizeObserver Response TextDecoder TextEncoder URL WebAssembly Worker addEventListener atob caches clearTimeout
  devicePixelRatio document fetch getComputedStyle history IDBKeyRange indexedDB innerHeight localStorage location matchMedia navigator
  performance print queueMicrotask removeEventListener requestAnimationFrame requestIdleCallback self setTimeout
  showSaveFilePicker`;
const NODE = "Buffer process";

const known = (text) => Object.fromEntries(text.trim().split(/\s+/).map((name) => [name, "readonly"]));

export default [
  js.configs.recommended,
  {
    languageOptions: { ecmaVersion: 2024, globals: { ...known(BROWSER), ...known(NODE) } },
    linterOptions: { reportUnusedDisableDirectives: "error" },
    rules: {
      "array-callback-return": "error",
      complexity: ["error", 12],
      "consistent-return": "error",
      eqeqeq: "error",
      "max-lines-per-function": ["error", { max: 60, skipComments: true }],
      "no-eval": "error",
      "no-implied-eval": "error",
      "no-new-func": "error",
      "no-param-reassign": "error",
      "no-restricted-properties": ["error", ...["innerHTML", "outerHTML", "insertAdjacentHTML"].map((property) =>
        ({ property, message: "Names and texts of files are never HTML" }))],
      "no-script-url": "error",
      "no-self-compare": "error",
      "no-shadow": "error",
      "no-unused-expressions": ["error", { allowShortCircuit: true }],
      "no-use-before-define": ["error", { functions: false, classes: false, variables: false }],
      "no-var": "error",
      "object-shorthand": "error",
      "prefer-const": "error",
      "prefer-template": "error",
      "require-atomic-updates": "off",
    },
  },
];
