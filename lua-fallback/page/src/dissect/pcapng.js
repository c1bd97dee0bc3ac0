// SPDX-License-Identifier: GPL-2.0-or-later
// The blocks of a pcapng file: which interface each packet came by, and the file again with some of its packets. What
// is in a packet is Wireshark's business.

const SECTION = 0x0a0d0d0a, INTERFACE = 1, PACKET = 2, SIMPLE_PACKET = 3, ENHANCED_PACKET = 6;
const LITTLE = 0x1a2b3c4d;
const ARCNET = [7, 129]; // link types; ARCNET of BSD and of Linux

export const isPcapng = (bytes) => bytes.length >= 28 && view(bytes).getUint32(0) === SECTION;

const view = (bytes) => new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);

// Yields {type, start, end, little}; ends before a block that is cut.
export function* blocks(bytes) {
  const data = view(bytes);
  let little = true;
  for (let start = 0; start + 12 <= bytes.length; ) {
    if (data.getUint32(start) === SECTION) little = data.getUint32(start + 8, true) === LITTLE;
    const type = data.getUint32(start, little);
    const end = start + data.getUint32(start + 4, little);
    if (end < start + 12 || end > bytes.length) return;
    yield { type, start, end, little };
    start = end;
  }
}

const isPacket = (block) => [PACKET, SIMPLE_PACKET, ENHANCED_PACKET].includes(block.type);

// Yields, for each packet, its section and interface, both from 0, and where the bytes of those on ARCNET are; the length
// of others is 0.
export function* places(bytes) {
  const data = view(bytes);
  let section = -1, links = [];
  for (const block of blocks(bytes)) {
    const { type, start, end, little } = block;
    if (type === SECTION) {
      section++;
      links = [];
    } else if (type === INTERFACE) {
      links.push(data.getUint16(start + 8, little));
    } else if (isPacket(block)) {
      const number = type === PACKET ? data.getUint16(start + 8, little)
        : type === ENHANCED_PACKET ? data.getUint32(start + 8, little) : 0;
      const isArcnet = ARCNET.includes(links[number]) && type === ENHANCED_PACKET && end >= start + 32;
      const length = isArcnet ? Math.min(data.getUint32(start + 20, little), end - start - 32) : 0;
      yield { section, number, start: start + 28, length };
    }
  }
}

// Tells whether packets come from several sections or interfaces, or from ARCNET.
export function isManifold(bytes) {
  if (!isPcapng(bytes)) return false;
  for (const { section, number, length } of places(bytes)) if (section > 0 || number > 0 || length > 0) return true;
  return false;
}

// Yields where each packet's bytes and its time stamp are: {data, time, little}.
export function* packets(bytes) {
  for (const { type, start, little } of blocks(bytes)) {
    if (type === ENHANCED_PACKET) yield { data: start + 28, time: start + 12, little };
  }
}

// Returns the file with only those packets whose numbers, from 1, are in a set.
export function only(bytes, numbers) {
  const kept = [];
  let number = 0;
  for (const block of blocks(bytes)) {
    if (!isPacket(block) || numbers.has(++number)) kept.push(bytes.subarray(block.start, block.end));
  }
  return new Blob(kept, { type: "application/vnd.tcpdump.pcap" });
}
