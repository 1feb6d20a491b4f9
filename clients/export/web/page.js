// The page of a scene: its objects as they lie on their table, played by touch, keyboard and MIDI.

import { Carom, missing } from "./carom.js";
import { Keyboard } from "./keyboard.js";

const PIANO = "awsedftgyhujkolp";
const HOLD = 380; // ms until a touch is a hold
const MOVED = 11; // px before a touch is a drag
const FLASH = 60; // ms
const WIDE = 2; // times as wide as high is an object
const METRES = 0.5; // that an object is wide, for the speed of a drag over it
const [SLOWEST, FASTEST] = [0.01, 5]; // m/s
const CONTROL = 0xb0, WHEEL = 1, SILENCE = 120;

const $ = (selector) => document.querySelector(selector);
const files = Carom.fetch();
let opening = null;
let selected = null;
let octave = 4;
let strokes = 0;
const keyboard = new Keyboard(send);

/** The scene, from the first gesture of a hand on. */
function scene() {
  opening ??= files.then(async (found) => {
    const context = new AudioContext({ sampleRate: found.map.rate, latencyHint: "interactive" });
    const made = await Carom.open(context, { files: found });
    await context.resume();
    await made.ready;
    return made;
  });
  return opening;
}

async function send(address, ...args) {
  try {
    return await (await scene()).send(address, ...args);
  } catch (error) {
    $("output").textContent = error.message;
  }
}

function choose(pad) {
  selected?.setAttribute("aria-pressed", "false");
  selected = pad;
  pad.setAttribute("aria-pressed", "true");
}

function strike(pad, ...args) {
  choose(pad);
  pad.classList.add("struck");
  setTimeout(() => pad.classList.remove("struck"), FLASH);
  send(`/object/${pad.dataset.name}/impact`, ...args);
}

function positionOn(pad, x) {
  const { left, width } = pad.getBoundingClientRect();
  return Math.max(0, Math.min(1, (x - left) / width));
}

/** All fingers on an object, and the keys that stand for a click. */
function touched(pad, body) {
  const fingers = new Map(); // by pointer: what it does
  pad.onpointerdown = (event) => {
    event.preventDefault();
    pad.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, stroke(pad, body, event));
  };
  pad.onpointermove = (event) => fingers.get(event.pointerId)?.moved(event);
  pad.onpointerup = pad.onpointercancel = ({ pointerId }) => {
    fingers.get(pointerId)?.lifted();
    fingers.delete(pointerId);
  };
  pad.onclick = ({ detail }) => detail || strike(pad); // 0: by Enter, the space bar, or what reads a page aloud
}

/** A finger on an object: it strikes; where it rests it presses, and where it is drawn it rolls or rubs. */
function stroke(pad, body, event) {
  const id = `stroke-${++strokes}`;
  const object = `/object/${pad.dataset.name}`;
  const velocity = event.pointerType === "pen" && event.pressure ? 0.05 * 100 ** event.pressure : body.velocity;
  const begun = { x: event.clientX, at: event.timeStamp };
  let [kind, last, speed] = ["touch", begun, 0];
  strike(pad, velocity, positionOn(pad, event.clientX));
  const timer = setTimeout(() => {
    kind = "hold";
    send(`${object}/press`, 5, positionOn(pad, begun.x), "striker", "hand", "id", id);
  }, HOLD);
  return {
    moved(move) {
      if (kind === "touch" && Math.abs(move.clientX - begun.x) > MOVED) {
        clearTimeout(timer);
        kind = "drag";
      }
      const position = positionOn(pad, move.clientX);
      if (kind === "hold") send(`/gesture/${id}/position`, position);
      if (kind !== "drag" && kind !== "moves") return;
      const metres = Math.abs(move.clientX - last.x) * METRES / pad.clientWidth;
      speed += (metres / Math.max(0.001, (move.timeStamp - last.at) / 1000) - speed) * 0.3;
      last = { x: move.clientX, at: move.timeStamp };
      const now = Math.max(SLOWEST, Math.min(FASTEST, speed));
      if (kind === "drag") {
        const rubs = body.usual.slide && !body.usual.roll;
        const how = body.usual.roll || rubs ? [] : ["striker", "ball-bearing", "surface", "wood", "roughness", 1.5];
        send(`${object}/${rubs ? "slide" : "roll"}`, now, position, ...how, "id", id);
        kind = "moves";
      } else {
        send(`/gesture/${id}/speed`, now);
        send(`/gesture/${id}/position`, position);
      }
    },
    lifted() {
      clearTimeout(timer);
      if (kind === "hold" || kind === "moves") send(`/gesture/${id}/stop`);
    },
  };
}

function pads(map) {
  return Object.entries(map.objects).filter(([, { stays }]) => stays).map(([name, { preset }]) => {
    const pad = document.createElement("button");
    Object.assign(pad, { textContent: name.replaceAll("-", " "), title: map.presets[preset].description });
    pad.dataset.name = name;
    touched(pad, map.presets[preset]);
    return pad;
  });
}

/** Lay each object where its table has it; without one in rows, as many as suit the window. */
function lay(all, objects) {
  const { clientWidth, clientHeight } = $("main");
  const columns = Math.max(1, Math.ceil(Math.sqrt((all.length * clientWidth) / (WIDE * Math.max(1, clientHeight)))));
  const rows = Math.ceil(all.length / columns);
  const most = 0.94 * Math.min(clientWidth / columns, (WIDE * clientHeight) / rows);
  all.forEach((pad, n) => {
    const { at } = objects[pad.dataset.name];
    const [x, y] = at ?? [((n % columns) + 0.5) / columns, (Math.floor(n / columns) + 0.5) / rows];
    Object.assign(pad.style, { left: `${100 * x}%`, top: `${100 * y}%` });
    pad.style.setProperty("--most", at ? "100%" : `${most}px`);
  });
}

function keys(all) {
  addEventListener("keydown", (event) => {
    if (event.repeat || event.ctrlKey || event.metaKey) return;
    const key = event.key.toLowerCase();
    const pad = all[Number(key) - 1];
    if (key === "escape") send("/panic");
    else if (pad) strike(pad);
    else if (key === "z" || key === "x") octave = Math.max(0, Math.min(8, octave + (key === "x" ? 1 : -1)));
    else if (PIANO.includes(key) && selected) note(selected, 12 * (octave + 1) + PIANO.indexOf(key), event.shiftKey ? 120 : 90);
  });
}

function note(pad, number, velocity) {
  send(`/object/${pad.dataset.name}/note`, number, velocity);
}

async function midi(all) {
  try {
    const access = await navigator.requestMIDIAccess();
    const attend = () => {
      for (const input of access.inputs.values()) input.onmidimessage = ({ data }) => heard(all, data);
      $("output").textContent = `MIDI: ${[...access.inputs.values()].map(({ name }) => name).join(", ") || "no keyboard is there yet"}`;
    };
    access.onstatechange = attend;
    attend();
  } catch (error) {
    $("output").textContent = `No MIDI in this browser: ${error.message}`;
  }
}

function heard(all, [status, first, second]) {
  const isControl = (status & 0xf0) === CONTROL;
  const pad = selected ?? all[0];
  if (!pad) return;
  if (isControl && first === WHEEL) send(`/object/${pad.dataset.name}/damp`, second / 127);
  else if (isControl && first === SILENCE) send("/panic");
  else keyboard.hear(pad.dataset.name, [status, first, second]);
}

files.catch((error) => ($("output").textContent = error.message));
const { map } = await files;
$("output").textContent = missing();
document.title = map.title;
$("h1").textContent = map.title;
const all = pads(map);
$("main").replaceChildren(...all);
lay(all, map.objects);
addEventListener("resize", () => lay(all, map.objects));
keys(all);
$("#midi").onclick = () => midi(all);
$("#score").onclick = async () => {
  try {
    (await scene()).load({ live: false });
    keyboard.forget();
  } catch (error) {
    $("output").textContent = error.message;
  }
};
