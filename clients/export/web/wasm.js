// WebAssembly whose code lies parted by what it holds, as `parting.py` parts it: joined again, to the byte.

const HEAD = 16; // bytes before the operands of all instructions
const TABLE = 256; // instructions by one byte
const REST = 0, LOCALS = 1, NUMBERS = 2, CONSTANTS = 3; // parts
const CODE = 10; // the section of functions

/** The module whose parts are given. */
export function joined(bytes) {
  const head = new Uint32Array(bytes.buffer, bytes.byteOffset, 4);
  const places = [HEAD + 3 * TABLE, ...head.slice(1)];
  const out = new Uint8Array(head[0]);
  const usual = new Uint16Array(1 << 16).map((_, n) => n), order = usual.slice();
  let at = 0;

  const move = (part, count) => {
    for (; count > 0; count--) out[at++] = bytes[places[part]++];
  };
  const number = (part) => {
    for (let value = 0, shift = 0; ; shift += 7) {
      const byte = (out[at++] = bytes[places[part]++]);
      value |= (byte & 127) << shift;
      if (byte < 128) return value;
    }
  };
  /** The local that its place in the list tells, which comes to the front. */
  const local = () => {
    const begin = at, place = number(LOCALS);
    let index = order[place];
    order.copyWithin(1, 0, place);
    order[0] = index;
    for (at = begin; index > 127; index >>= 7) out[at++] = (index & 127) | 128;
    out[at++] = index;
  };
  const place = () => {
    number(REST);
    number(NUMBERS);
  };
  const operands = [
    () => {},
    () => move(REST, 1),
    () => move(REST, 2),
    () => number(REST),
    () => {
      for (let n = number(REST); n >= 0; n--) number(REST);
    },
    local,
    place,
    () => {
      place();
      move(REST, 1);
    },
    () => number(NUMBERS),
    () => move(CONSTANTS, 4),
    () => move(CONSTANTS, 8),
    () => move(CONSTANTS, 16),
    () => follow(TABLE + number(REST)),
    () => follow(2 * TABLE + number(REST)),
  ];
  const follow = (code) => operands[bytes[HEAD + code]]();

  const joinFunction = () => {
    const end = number(REST) + at;
    for (let n = number(REST); n > 0; n--) {
      number(REST);
      move(REST, 1);
    }
    order.set(usual);
    while (at < end) {
      move(REST, 1);
      follow(out[at - 1]);
    }
  };

  move(REST, 8);
  while (at < out.length) {
    move(REST, 1);
    const section = out[at - 1];
    const end = number(REST) + at;
    if (section === CODE) for (let n = number(REST); n > 0; n--) joinFunction();
    move(REST, end - at);
  }
  return out;
}
