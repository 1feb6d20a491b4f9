// A scene's tables of mode shapes, from the few numbers that tell them: to the bit as the engine's makers have them.

import { Bits, models } from "./bits.js";

const SUM = 0, STEPS = 1; // kinds of columns; others have their values' bits
const LENGTH = 6, KIND = 2, EXPONENT = 11; // bits
const LEAST = 1023; // what is added to an exponent
const STEP = 17; // bits of a step below a column's scale

/** A decoder of sequences of whole numbers. */
class Numbers {
  constructor(bits) {
    this.bits = bits;
    this.models = models(2 << (2 * LENGTH));
  }

  next(count) {
    const numbers = new Float64Array(count);
    let before = 0, last = 0;
    for (let n = 0; n < count; n++) {
      const length = this.bits.tree(this.models, (2 * before + (last > 0)) << LENGTH, LENGTH);
      if (length) {
        const told = this.bits.direct(length), top = 2 ** (length - 1);
        numbers[n] = told < top ? top + told : -told;
      }
      [before, last] = [last, length];
    }
    return numbers;
  }
}

/** The polynomials that are orthonormal on so many rows, by the recurrence of Gram's polynomials. */
function polynomials(rows, terms) {
  const found = [new Float64Array(rows).fill(1 / Math.sqrt(rows))];
  let before = new Float64Array(rows), last = 0;
  for (let k = 1; k < terms; k++) {
    const square = k * k;
    const factor = Math.sqrt((square * (rows * rows - square)) / (4 * square - 1)) / (rows - 1);
    const now = found[k - 1];
    found.push(now.map((value, n) => (((2 * n - (rows - 1)) / (rows - 1)) * value - last * before[n]) / factor));
    [before, last] = [now, factor];
  }
  return found;
}

/** The values of tables, each of which says its rows, columns and terms; bytes: the coded ones, from a place on. */
export function decoded(tables, bytes, at) {
  const bits = new Bits(bytes, at);
  const kinds = models(1 << KIND), numbers = [new Numbers(bits), new Numbers(bits)];
  return tables.map(([, rows, columns, terms]) => {
    const values = new Float32Array(rows * columns), words = new Uint32Array(values.buffer);
    const basis = polynomials(rows, terms);
    for (let column = 0; column < columns; column++) {
      const kind = bits.tree(kinds, 0, KIND);
      if (kind > STEPS) {
        for (let row = 0; row < rows; row++) words[row * columns + column] = bits.direct(32);
        continue;
      }
      const scale = 2 ** (bits.direct(EXPONENT) - LEAST);
      const told = numbers[kind].next(kind === SUM ? terms : rows);
      const sums = new Float64Array(rows);
      if (kind === SUM) {
        told.forEach((number, k) => number && basis[k].forEach((value, row) => (sums[row] += value * number)));
      } else {
        for (let row = 0, slope = 0, sum = 0; row < rows; row++) sums[row] = sum += slope += told[row];
      }
      for (let row = 0; row < rows; row++) values[row * columns + column] = sums[row] * 2 ** -STEP * scale;
    }
    return values;
  });
}
