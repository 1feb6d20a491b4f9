// When to draw: all that is looked at in one frame, and frames so seldom that a finger hardly ever waits for one.

const SHARE = 0.1; // of the time that frames may take
const FOLLOWED = 0.1; // of the difference by which a frame changes the mean cost
const waiting = new Set();
const after = new MessageChannel();
let asked = false;
let ended = 0; // ms
let cost = 4; // ms of a frame, with what the browser itself does for it

/** Have a function called in the next frame: once, however often it is asked for. */
export function draw(picture) {
  waiting.add(picture);
  ask();
}

function ask() {
  if (asked) return;
  asked = true;
  const wait = ended + cost / SHARE - cost - performance.now();
  if (wait > 4) setTimeout(requestAnimationFrame, wait, frame);
  else requestAnimationFrame(frame);
}

function frame() {
  const begun = performance.now();
  const pictures = [...waiting];
  waiting.clear();
  for (const picture of pictures) picture();
  after.port2.postMessage(begun); // comes back when the browser is done with the frame
}

after.port1.onmessage = ({ data: begun }) => {
  ended = performance.now();
  cost += (ended - begun - cost) * FOLLOWED;
  asked = false;
  if (waiting.size) ask();
};
