// When to draw: one picture in a frame, and frames so seldom that a finger hardly ever waits for one, and never for long.

const SHARE = 0.1; // of the time that frames may take
const FOLLOWED = 0.1; // of the difference by which a frame changes the mean cost
const waiting = new Set();
const after = new MessageChannel();
let asked = false;
let ended = 0; // ms
let cost = 4; // ms of a frame, with what the browser itself does for it

/** Have a function called in a frame soon, after those that were asked for before: once, however often that is. */
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
  const [picture] = waiting;
  waiting.delete(picture);
  try {
    picture();
  } finally {
    after.port2.postMessage(begun); // comes back when the browser is done with the frame
  }
}

after.port1.onmessage = ({ data: begun }) => {
  ended = performance.now();
  cost += (ended - begun - cost) * FOLLOWED;
  asked = false;
  if (waiting.size) ask();
};
