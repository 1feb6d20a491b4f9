// SHA-256, as FIPS 180-4 has it: browsers have it too, but only for pages that come over TLS.

/** The first 32 bits behind the point of a root. */
const bits = (root) => Math.floor((root % 1) * 2 ** 32);

const PRIMES = Array.from({ length: 312 }, (_, n) => n).filter((n) => n > 1 && !Array.from({ length: n }, (_, k) => k).some((k) => k > 1 && n % k === 0));
const CONSTANTS = PRIMES.map((prime) => bits(Math.cbrt(prime)));
const FIRST = PRIMES.slice(0, 8).map((prime) => bits(Math.sqrt(prime)));

/** The sum of some bytes, in hexadecimal. */
export function sumOf(bytes) {
  const padded = new Uint8Array(Math.ceil((bytes.length + 9) / 64) * 64);
  padded.set(bytes);
  padded[bytes.length] = 0x80;
  const view = new DataView(padded.buffer);
  view.setUint32(padded.length - 8, bytes.length / 2 ** 29);
  view.setUint32(padded.length - 4, bytes.length << 3);
  const hash = Uint32Array.from(FIRST), words = new Uint32Array(64);
  const turned = (x, by) => (x >>> by) | (x << (32 - by));
  for (let at = 0; at < padded.length; at += 64) {
    for (let n = 0; n < 16; n++) words[n] = view.getUint32(at + 4 * n);
    for (let n = 16; n < 64; n++) {
      const x = words[n - 15], y = words[n - 2];
      words[n] = words[n - 16] + (turned(x, 7) ^ turned(x, 18) ^ (x >>> 3)) + words[n - 7] + (turned(y, 17) ^ turned(y, 19) ^ (y >>> 10));
    }
    let [a, b, c, d, e, f, g, h] = hash;
    for (let n = 0; n < 64; n++) {
      const one = (h + (turned(e, 6) ^ turned(e, 11) ^ turned(e, 25)) + ((e & f) ^ (~e & g)) + CONSTANTS[n] + words[n]) | 0;
      const other = ((turned(a, 2) ^ turned(a, 13) ^ turned(a, 22)) + ((a & b) ^ (a & c) ^ (b & c))) | 0;
      [h, g, f, e, d, c, b, a] = [g, f, e, (d + one) | 0, c, b, a, (one + other) | 0];
    }
    [a, b, c, d, e, f, g, h].forEach((each, n) => (hash[n] += each));
  }
  return [...hash].map((each) => each.toString(16).padStart(8, "0")).join("");
}
