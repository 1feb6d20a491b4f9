// Files that were compressed as LZMA (the format .lzma): by a third smaller than as gzip, which is what browsers know.
// The algorithm is that of the LZMA specification by Igor Pavlov, which is in the public domain.

import { Bits, models } from "./bits.js";

const HEAD = 13; // bytes: 1 of properties, 4 that tell the dictionary's size, 8 the content's
const STATES = 12;
const SHORTEST = 2; // of a match, in bytes
const FIRST = 4; // the first distance that has direct bits
const ALIGNED = 4; // low bits of a long distance that have a model of their own

/** A decoder of lengths of matches. */
class Lengths {
  constructor() {
    this.choice = models(2);
    this.low = models(16 << 3);
    this.middle = models(16 << 3);
    this.high = models(256);
  }

  next(bits, place) {
    if (!bits.bit(this.choice, 0)) return SHORTEST + bits.tree(this.low, place << 3, 3);
    if (!bits.bit(this.choice, 1)) return SHORTEST + 8 + bits.tree(this.middle, place << 3, 3);
    return SHORTEST + 16 + bits.tree(this.high, 0, 8);
  }
}

/** The content of a file whose head says how large it is. */
export function unpacked(bytes) {
  const lc = bytes[0] % 9, lp = Math.floor(bytes[0] / 9) % 5, pb = Math.floor(bytes[0] / 45);
  const size = new DataView(bytes.buffer, bytes.byteOffset).getUint32(5, true);
  const out = new Uint8Array(size);
  const bits = new Bits(bytes, HEAD);
  const literal = models(0x300 << (lc + lp));
  const isMatch = models(STATES << 4), isLong = models(STATES << 4);
  const isRep = models(STATES), isRep0 = models(STATES), isRep1 = models(STATES), isRep2 = models(STATES);
  const slots = models(4 << 6), far = models(128), low = models(1 << ALIGNED);
  const lengths = new Lengths(), again = new Lengths();
  let state = 0, at = 0, rep0 = 0, rep1 = 0, rep2 = 0, rep3 = 0;

  const plain = () => {
    const before = at ? out[at - 1] : 0;
    const base = 0x300 * (((at & ((1 << lp) - 1)) << lc) + (before >>> (8 - lc)));
    let symbol = 1;
    if (state >= 7) {
      let other = out[at - rep0 - 1];
      do {
        const expected = (other >>> 7) & 1;
        other <<= 1;
        const bit = bits.bit(literal, base + ((1 + expected) << 8) + symbol);
        symbol = (symbol << 1) | bit;
        if (expected !== bit) break;
      } while (symbol < 0x100);
    }
    while (symbol < 0x100) symbol = (symbol << 1) | bits.bit(literal, base + symbol);
    out[at++] = symbol & 0xff;
    state = state < 4 ? 0 : state < 10 ? state - 3 : state - 6;
  };

  const distance = (length) => {
    const slot = bits.tree(slots, Math.min(length - SHORTEST, 3) << 6, 6);
    if (slot < FIRST) return slot;
    const direct = (slot >> 1) - 1;
    const base = (2 | (slot & 1)) * 2 ** direct;
    if (slot < 14) return base + bits.reversed(far, base - slot, direct);
    return base + bits.direct(direct - ALIGNED) * 2 ** ALIGNED + bits.reversed(low, 0, ALIGNED);
  };

  while (at < size) {
    const place = at & ((1 << pb) - 1);
    if (!bits.bit(isMatch, (state << 4) + place)) {
      plain();
      continue;
    }
    let length;
    if (bits.bit(isRep, state)) {
      if (!bits.bit(isRep0, state)) {
        if (!bits.bit(isLong, (state << 4) + place)) {
          state = state < 7 ? 9 : 11;
          out[at] = out[at - rep0 - 1];
          at++;
          continue;
        }
      } else if (!bits.bit(isRep1, state)) {
        [rep0, rep1] = [rep1, rep0];
      } else if (!bits.bit(isRep2, state)) {
        [rep0, rep1, rep2] = [rep2, rep0, rep1];
      } else {
        [rep0, rep1, rep2, rep3] = [rep3, rep0, rep1, rep2];
      }
      length = again.next(bits, place);
      state = state < 7 ? 8 : 11;
    } else {
      [rep1, rep2, rep3] = [rep0, rep1, rep2];
      length = lengths.next(bits, place);
      state = state < 7 ? 7 : 10;
      rep0 = distance(length);
    }
    if (rep0 >= at || at + length > size) throw new Error("expected a file that Carom has compressed");
    for (const end = at + length; at < end; at++) out[at] = out[at - rep0 - 1];
  }
  return out;
}
