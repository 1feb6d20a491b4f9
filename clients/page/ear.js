// A worker with a web socket of its own for the sound: what the page draws does not hold it up on its way.

import { decode } from "./osc.js";

const AGAIN = 1000; // ms
let player = null; // the port of the AudioWorklet, where there is one

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
    postMessage(block);
  };
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
