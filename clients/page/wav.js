// A WAV file of 32-bit floats: the engine's own samples.

/** A Blob of blocks of [left, right]. */
export function wav(blocks, rate) {
  const frames = blocks.reduce((sum, [left]) => sum + left.length, 0);
  const head = new DataView(new ArrayBuffer(58));
  const word = (at, letters) => [...letters].forEach((letter, n) => head.setUint8(at + n, letter.charCodeAt(0)));
  word(0, "RIFF");
  head.setUint32(4, 50 + 8 * frames, true);
  word(8, "WAVEfmt ");
  head.setUint32(16, 18, true);
  head.setUint16(20, 3, true); // floats
  head.setUint16(22, 2, true);
  head.setUint32(24, rate, true);
  head.setUint32(28, 8 * rate, true);
  head.setUint16(32, 8, true);
  head.setUint16(34, 32, true);
  word(38, "fact");
  head.setUint32(42, 4, true);
  head.setUint32(46, frames, true);
  word(50, "data");
  head.setUint32(54, 8 * frames, true);
  const parts = blocks.map(([left, right]) => {
    const out = new Float32Array(2 * left.length);
    for (let n = 0; n < left.length; n++) {
      out[2 * n] = left[n];
      out[2 * n + 1] = right[n];
    }
    return out;
  });
  return new Blob([head, ...parts], { type: "audio/wav" });
}
