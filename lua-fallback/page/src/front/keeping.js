// SPDX-License-Identifier: GPL-2.0-or-later
// Where the blocks of a capture go while it is heard: into the browser's storage, from where they can be had after the
// page was closed or the browser has ended; or into memory.

const DATABASE = "sis-heard", NAMES = "names", BLOCKS = "blocks"; // IndexedDB: it works for a page in a file, too
const WRITTEN_MS = 2000, WRITTEN_BYTES = 1 << 16; // blocks are written together: after so long, or so many
const READ = 256; // pieces that are read at once
const TOGETHER = 1 << 20; // bytes that are kept in memory before the browser may put them elsewhere
const FULL = "The browser has no more room for what is heard. Listening has ended, and what came until then is kept";

const size = (chunks) => chunks.reduce((sum, { length }) => sum + length, 0);

export class InMemory {
  parts = [];
  chunks = [];

  async add(chunk) {
    if (chunk.length) this.chunks.push(chunk);
    if (size(this.chunks) < TOGETHER) return;
    this.parts.push(new Blob(this.chunks));
    this.chunks = [];
  }

  async whole() {
    return new Blob([...this.parts, ...this.chunks]);
  }

  async drop() {}
}

const done = (request) => new Promise((resolve, reject) => {
  request.onsuccess = () => resolve(request.result);
  request.onerror = () => reject(request.error);
});

const committed = (transaction) => new Promise((resolve, reject) => {
  transaction.oncomplete = resolve;
  transaction.onabort = () => reject(transaction.error ?? new Error("it was cancelled"));
});

let opened = null; // a promise of the database

function database() {
  opened ??= new Promise((resolve, reject) => {
    const request = indexedDB.open(DATABASE, 1);
    request.onupgradeneeded = () => {
      request.result.createObjectStore(NAMES, { autoIncrement: true });
      request.result.createObjectStore(BLOCKS);
    };
    done(request).then(resolve, reject);
  });
  return opened;
}

// All pieces of a capture; their keys are [capture, number].
const piecesOf = (id, from = 0) => IDBKeyRange.bound([id, from], [id, Infinity]);
const lockOf = (id) => `${DATABASE}-${id}`;

export class InStorage {
  constructor(id, name) {
    this.id = id;
    this.name = name;
    this.number = 0; // of the next piece
    this.chunks = []; // that are not written yet
    this.writtenMs = performance.now();
    /** @type {((value?: any) => void) | undefined} */ this.release = undefined; // lets other pages offer it
  }

  // Begins a capture. While this page is open, no other one offers it.
  static async begin(name) {
    const store = (await database()).transaction(NAMES, "readwrite").objectStore(NAMES);
    const kept = new InStorage(await done(store.add({ name })), name);
    navigator.locks?.request(lockOf(kept.id), () => new Promise((resolve) => (kept.release = resolve))).catch(() => {});
    return kept;
  }

  // Returns the captures that were not ended.
  static async left() {
    const store = (await database()).transaction(NAMES).objectStore(NAMES);
    const [ids, found] = await Promise.all([done(store.getAllKeys()), done(store.getAll())]);
    const { held } = (await navigator.locks?.query().catch(() => null)) ?? { held: [] };
    const isOpen = (id) => held.some(({ name }) => name === lockOf(id));
    return ids.map((id, place) => new InStorage(id, found[place].name)).filter(({ id }) => !isOpen(id));
  }

  // Called often, also with no bytes: then older ones are written.
  async add(chunk) {
    if (chunk.length) this.chunks.push(chunk);
    const isTime = performance.now() - this.writtenMs > WRITTEN_MS || size(this.chunks) > WRITTEN_BYTES;
    if (isTime && this.chunks.length) await this.write();
  }

  async write() {
    const piece = new Uint8Array(await new Blob(this.chunks).arrayBuffer());
    try {
      const transaction = (await database()).transaction(BLOCKS, "readwrite");
      transaction.objectStore(BLOCKS).add(piece, [this.id, this.number]);
      await committed(transaction);
    } catch ({ message }) {
      throw new Error(`${FULL} (${message})`);
    }
    this.number++;
    this.chunks = [];
    this.writtenMs = performance.now();
  }

  // Returns the capture, with what could not be written.
  async whole() {
    const parts = [];
    for (let from = 0, pieces = null; pieces?.length !== 0; from += READ) {
      const store = (await database()).transaction(BLOCKS).objectStore(BLOCKS);
      pieces = await done(store.getAll(piecesOf(this.id, from), READ));
      parts.push(new Blob(pieces));
    }
    return new Blob([...parts, ...this.chunks]);
  }

  async drop() {
    const transaction = (await database()).transaction([NAMES, BLOCKS], "readwrite");
    transaction.objectStore(NAMES).delete(this.id);
    transaction.objectStore(BLOCKS).delete(piecesOf(this.id));
    await committed(transaction);
    this.release?.();
  }
}

// Begins to keep a capture as well as this browser can: a private window may have no storage.
export const keepAs = (name) => InStorage.begin(name).catch(() => new InMemory());
