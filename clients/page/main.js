// The page: puts its parts together.

import { Controls } from "./controls.js";
import { Delay } from "./delay.js";
import { Hands } from "./hands.js";
import { Keys } from "./keys.js";
import { Link } from "./link.js";
import { Listener } from "./listener.js";
import { Midi } from "./midi.js";
import { presets, strikers, touches } from "./palettes.js";
import { Scene } from "./scene.js";
import { Shelf } from "./shelf.js";
import { Sound } from "./sound.js";
import { Table } from "./table.js";
import { HEAD, read } from "./tables.js";
import { Touch } from "./touch.js";
import { Views } from "./views.js";

const $ = (id) => document.getElementById(id);
const MODES = ["play", "move", "turn"];
const SHOWN = 6000; // ms of a notice

function notice(text, kind = "") {
  const line = document.createElement("p");
  line.textContent = text;
  line.className = kind;
  $("notices").append(line);
  while ($("notices").children.length > 3) $("notices").firstChild.remove();
  setTimeout(() => line.remove(), SHOWN);
}

function saved(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

function pressed(button, on) {
  button.setAttribute("aria-pressed", String(on));
}

async function catalogue() {
  const response = await fetch("/page/catalogue.json");
  if (!response.ok) throw new Error(await response.text());
  return response.json();
}

function tellProblems(link, scene) {
  link.on("/fail", (address, reason) => scene.restored.has(reason.match(/^name = (\S+): there is/)?.[1]) || notice(`${address}: ${reason}`, "bad"));
  link.on("/warning", (text) => notice(text));
  link.addEventListener("lost", () => document.body.classList.add("lost"));
  link.addEventListener("open", () => document.body.classList.remove("lost"));
}

function setUpSound(link, sound) {
  const switchTo = async (on) => {
    pressed($("sound"), on);
    try {
      await (on ? sound.start() : sound.stop());
    } catch (error) {
      notice(`No sound in this browser: ${error.message}`, "bad");
    }
  };
  $("sound").onclick = () => switchTo(!sound.isHeard);
  link.on("/status.reply", (...values) => {
    const device = values[values.indexOf("device") + 1];
    if (device !== "none" && device !== "page") return;
    // Nothing else plays the sound: the first touch of the page makes it heard, once its message is on its way, as a
    // browser takes 50 ms to begin. Browsers ask for a touch.
    for (const type of ["pointerdown", "keydown"]) {
      addEventListener(type, (event) => event.target !== $("sound") && !sound.isHeard && switchTo(true), { once: true });
    }
  });
  link.addEventListener("open", () => link.send("/status"), { once: true });
  $("record").onclick = () => {
    if (!sound.recording) {
      sound.startRecording();
      pressed($("record"), true);
      return;
    }
    const { first, lost, file } = sound.stopRecording();
    pressed($("record"), false);
    saved(file, `carom-from-sample-${first}.wav`);
    if (lost) notice(`${lost} samples are missing in the recording: the connection is too slow`, "bad");
  };
}

/** Open a file: a table is laid, any other score is played. */
async function open(link, scene, file) {
  const text = await file.text();
  if (text.startsWith(HEAD)) {
    scene.open(read(text));
    return;
  }
  const response = await fetch(`/page/score?client=${encodeURIComponent(link.client)}`, { method: "POST", body: file });
  if (!response.ok) throw new Error(await response.text());
  const { messages, seconds } = await response.json();
  notice(`${file.name}: ${messages} messages, ${seconds.toFixed(1)} s`);
}

function setUpScores(openFile) {
  let depth = 0;
  const show = (on) => ($("drop").hidden = !on);
  addEventListener("dragenter", (event) => event.dataTransfer?.types.includes("Files") && (++depth, show(true)));
  addEventListener("dragleave", () => show((depth = Math.max(0, depth - 1)) > 0));
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    show((depth = 0) > 0);
    const file = event.dataTransfer?.files[0];
    if (file) openFile(file);
  });
}

function setUpTheme() {
  const root = document.documentElement, light = matchMedia("(prefers-color-scheme: light)");
  const follow = () => (root.dataset.theme = localStorage.getItem("carom-theme") ?? (light.matches ? "light" : "dark"));
  follow();
  light.onchange = follow;
  $("theme").onclick = () => {
    localStorage.setItem("carom-theme", root.dataset.theme === "dark" ? "light" : "dark");
    follow();
  };
}

function setUpSheets() {
  for (const button of document.querySelectorAll("nav button")) {
    button.onclick = () => {
      const { sheet } = button.dataset;
      document.body.dataset.sheet = document.body.dataset.sheet === sheet ? "" : sheet;
      for (const each of document.querySelectorAll("nav button")) {
        each.setAttribute("aria-expanded", String(each.dataset.sheet === document.body.dataset.sheet));
      }
    };
  }
  $("table").addEventListener("pointerdown", () => (document.body.dataset.sheet = ""));
}

function setUpHelp(sound) {
  $("help").onclick = () => $("help-text").showModal();
  if (sound.hasWorklet) return;
  $("missing").textContent = isSecureContext
    ? "This browser lacks sound with low latency."
    : "From another machine browsers allow low latency over https only: start carom page --bind 0.0.0.0 --tls.";
}

function setUpHint(hands) {
  if (localStorage.getItem("carom-met")) return;
  $("hint").hidden = false;
  $("hint").textContent = "Tap to strike · hold to mute · drag along to roll · drag off to pull back";
  hands.addEventListener("struck", () => {
    localStorage.setItem("carom-met", "1");
    setTimeout(() => ($("hint").hidden = true), 4000);
  }, { once: true });
}

function setUpEmpty(scene) {
  const show = () => ($("empty").hidden = !scene.isKnown || scene.objects.size > 0 || scene.pending.size > 0);
  scene.addEventListener("changed", show);
  $("begin").onclick = () => scene.lay(scene.first());
}

async function start() {
  setUpTheme();
  const link = new Link();
  const scene = new Scene(link, await catalogue());
  tellProblems(link, scene);
  const sound = new Sound(link);
  const hands = new Hands(link, scene);
  const table = new Table($("table"), scene);
  const listener = new Listener($("space"), $("listener"), scene, table);
  const touch = (table.touch = new Touch(table.stage, table, hands));
  const delay = new Delay(link, hands, sound);
  const views = new Views(scene, sound, delay);
  const controls = new Controls($("inspector"), scene, hands);
  const silence = () => link.send("/panic");
  const keys = new Keys(scene, hands, table, silence);
  presets($("presets"), $("search"), scene, table);
  touches($("touches"), hands);
  strikers($("strikers"), hands, () => controls.show());
  hands.addEventListener("dropped", ({ detail }) => {
    const chosen = hands.chosen[detail.gesture];
    table.marks.follow(detail, { ...hands.strikerOf(detail.object), ...chosen }, chosen.gravity);
  });
  for (const mode of MODES) {
    $(`mode-${mode}`).onclick = () => {
      touch.mode = mode;
      for (const each of MODES) pressed($(`mode-${each}`), each === mode);
    };
  }
  const showTurn = () => ($("mode-turn").hidden = ![...scene.objects.values()].some(({ body }) => body.turned));
  scene.addEventListener("changed", showTurn);
  $("silence").onclick = silence;
  $("undo").onclick = () => scene.undo();
  scene.addEventListener("done", () => ($("undo").disabled = !scene.done.length));
  setUpSound(link, sound);
  const openFile = (file) => open(link, scene, file).catch((error) => notice(`${file.name}: ${error.message}`, "bad"));
  setUpScores(openFile);
  setUpEmpty(scene);
  const midi = new Midi($("midi"), $("midi-open"), scene, hands, silence);
  new Shelf($("tables"), scene, openFile, saved);
  addEventListener("pagehide", () => scene.keep());
  setUpSheets();
  setUpHelp(sound);
  setUpHint(hands);
  controls.show();
  link.open();
  window.carom = { link, scene, listener, sound, delay, hands, table, touch, views, keys, midi };
}

start().catch((error) => notice(`The page can't start: ${error.message}`, "bad"));
