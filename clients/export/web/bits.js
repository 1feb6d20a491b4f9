// Bits whose odds are learned, as LZMA codes them.

/** A decoder of bits by their probabilities, of 2^-11, which adapt. */
export class Bits {
  /** at: where the coded bytes begin, of which the first is 0. */
  constructor(bytes, at) {
    this.bytes = bytes;
    this.at = at + 1;
    this.range = 0xffffffff;
    this.code = 0;
    for (let n = 0; n < 4; n++) this.code = ((this.code << 8) | this.bytes[this.at++]) >>> 0;
  }

  bit(model, place) {
    const bound = (this.range >>> 11) * model[place];
    const one = this.code >= bound;
    if (one) {
      this.range -= bound;
      this.code -= bound;
      model[place] -= model[place] >>> 5;
    } else {
      this.range = bound;
      model[place] += (2048 - model[place]) >>> 5;
    }
    this.fill();
    return one ? 1 : 0;
  }

  fill() {
    if (this.range < 0x1000000) {
      if (this.at > this.bytes.length + 4) throw new Error("expected a file that Carom has compressed, and it ends early");
      this.range = (this.range << 8) >>> 0;
      this.code = ((this.code << 8) | this.bytes[this.at++]) >>> 0;
    }
  }

  /** A number of so many bits of even odds. */
  direct(count) {
    let number = 0;
    for (; count > 0; count--) {
      this.range >>>= 1;
      const one = this.code >= this.range;
      if (one) this.code -= this.range;
      number = number * 2 + (one ? 1 : 0);
      this.fill();
    }
    return number;
  }

  /** A number of so many bits, the highest first, whose models begin at a place. */
  tree(model, place, count) {
    let node = 1;
    for (let n = 0; n < count; n++) node = (node << 1) | this.bit(model, place + node);
    return node - (1 << count);
  }

  /** The same, the lowest first. */
  reversed(model, place, count) {
    let node = 1, number = 0;
    for (let n = 0; n < count; n++) {
      const one = this.bit(model, place + node);
      node = (node << 1) | one;
      number |= one << n;
    }
    return number;
  }
}

export const models = (count) => new Uint16Array(count).fill(1024);
