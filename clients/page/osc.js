// OSC 1.0 packets, written and read: the arguments that Carom knows.

const text = new TextEncoder();
const plain = new TextDecoder();

function padded(string) {
  const bytes = text.encode(string);
  const out = new Uint8Array((bytes.length >> 2) * 4 + 4);
  out.set(bytes);
  return out;
}

function number(value) {
  const whole = Number.isInteger(value) && Math.abs(value) < 2 ** 31;
  const out = new DataView(new ArrayBuffer(whole ? 4 : 8));
  if (whole) out.setInt32(0, value);
  else out.setFloat64(0, value);
  return [whole ? "i" : "d", new Uint8Array(out.buffer)];
}

/** Arguments as [type tags, bytes]. */
function argument(value) {
  if (Array.isArray(value)) {
    const inner = value.map(argument);
    return [`[${inner.map(([tags]) => tags).join("")}]`, ...inner.flatMap(([, ...bytes]) => bytes)];
  }
  return typeof value === "number" ? number(value) : ["s", padded(String(value))];
}

/** A message as a packet: numbers go as i or d, lists as such, all else as a string. */
export function encode(address, ...args) {
  const parts = args.map(argument);
  const chunks = [padded(address), padded("," + parts.map(([tags]) => tags).join("")), ...parts.flatMap(([, ...bytes]) => bytes)];
  const out = new Uint8Array(chunks.reduce((sum, each) => sum + each.length, 0));
  let at = 0;
  for (const each of chunks) {
    out.set(each, at);
    at += each.length;
  }
  return out;
}

/** The message in a packet, as {address, args}; blobs are views of the packet. */
export function decode(buffer) {
  const view = new DataView(buffer);
  const bytes = new Uint8Array(buffer);
  let at = 0;
  const string = () => {
    const end = bytes.indexOf(0, at);
    const found = plain.decode(bytes.subarray(at, end));
    at = (end >> 2) * 4 + 4;
    return found;
  };
  const address = string();
  const args = [];
  for (const tag of string().slice(1)) {
    if (tag === "i") args.push(view.getInt32((at += 4) - 4));
    else if (tag === "f") args.push(view.getFloat32((at += 4) - 4));
    else if (tag === "h") args.push(Number(view.getBigInt64((at += 8) - 8)));
    else if (tag === "d") args.push(view.getFloat64((at += 8) - 8));
    else if (tag === "s") args.push(string());
    else if (tag === "b") {
      const size = view.getInt32(at);
      args.push(new DataView(buffer, at + 4, size));
      at += 4 + size + (-size & 3);
    } else if (tag === "T" || tag === "F") args.push(tag === "T");
  }
  return { address, args };
}
