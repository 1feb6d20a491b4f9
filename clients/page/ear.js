// A worker with a web socket of its own for the sound: what the page draws does not hold it up on its way.

import { decode } from "./osc.js";

const AGAIN = 1000; // ms
const AT_ONCE = 1024; // frames that the page gets in one piece; the player gets each block as it comes
let player = null; // the port of the AudioWorklet, where there is one
let blocks = []; // for the page

onmessage = ({ data }) => {
  if (data.player) player = data.player;
  if (data.address) connect(data.address);
};

function connect(address) {
  const socket = new WebSocket(address);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => socket.send(JSON.stringify({ COMMAND: "SOUND", DATA: true }));
  socket.onclose = () => setTimeout(connect, AGAIN, address);
  socket.onmessage = ({ data }) => {
    if (typeof data === "string") return;
    const { address, args } = decode(data);
    if (address !== "/sound") return;
    const block = parted(...args);
    player?.postMessage(block);
    gather(block);
  };
}

/** Hand blocks that follow each other on to the page, some at once. */
function gather(block) {
  const last = blocks.at(-1);
  if (last && last.position + last.left.length !== block.position) flush();
  blocks.push(block);
  if (blocks.reduce((sum, { left }) => sum + left.length, 0) >= AT_ONCE) flush();
}

function flush() {
  const [{ position, rate }] = blocks;
  postMessage({ position, rate, left: joined(blocks.map(({ left }) => left)), right: joined(blocks.map(({ right }) => right)) });
  blocks = [];
}

function joined(pieces) {
  const out = new Float32Array(pieces.reduce((sum, each) => sum + each.length, 0));
  let at = 0;
  for (const each of pieces) {
    out.set(each, at);
    at += each.length;
  }
  return out;
}

/** A block of sound by channels: the first two. */
function parted(position, rate, channels, data) {
  const frames = data.byteLength / 4 / channels;
  const left = new Float32Array(frames);
  const right = new Float32Array(frames);
  for (let n = 0; n < frames; n++) {
    left[n] = data.getFloat32(4 * channels * n, true);
    right[n] = channels > 1 ? data.getFloat32(4 * (channels * n + 1), true) : left[n];
  }
  return { position, rate, left, right };
}
