// The objects on the table: what the server has, where they lie, what was done last.

import { bodyOf } from "./bodies.js";

const SPOTS = [[0.5, 0.48], [0.2, 0.26], [0.81, 0.24], [0.18, 0.78], [0.81, 0.76], [0.5, 0.87], [0.5, 0.1], [0.1, 0.52], [0.9, 0.5]];
const FIRST = ["church-bell", "wine-glass", "steel-plate", "wood-board", "singing-bowl", "marimba-bar"];
const SOFTEST = -72; // dB at which an object is dark
const KEPT = "carom-places";

const isCopy = (name) => /.\.\d+(\.\d+)?$/.test(name);
const isTrial = (name) => name.startsWith("try~");

export class Scene extends EventTarget {
  constructor(link, catalogue) {
    super();
    this.link = link;
    this.catalogue = catalogue;
    this.presets = new Map(catalogue.objects.map((each) => [each.name, each]));
    this.strikers = new Map(catalogue.strikers.map((each) => [each.name, each]));
    this.objects = new Map();
    this.selected = null;
    this.done = [];
    this.pending = new Set(); // names of objects that were asked for
    this.places = JSON.parse(localStorage.getItem(KEPT) ?? "{}");
    this.trials = 0;
    this.isNew = true;
    link.on("/objects.reply", (first, total, ...pairs) => this.meet(first, total, pairs));
    link.on("/object.added", (name, preset) => this.appear(name, preset));
    link.on("/object.removed", (name) => this.vanish(name));
    link.on("/modes", (name, level, ...pairs) => this.ring(name, level, pairs));
    link.addEventListener("open", () => {
      link.send("/notify", 3);
      link.send("/objects");
    });
  }

  /** What the server has as the page comes to it; a server without objects gets some. */
  meet(first, total, pairs) {
    const there = new Set();
    for (let n = 0; n < pairs.length; n += 2) {
      there.add(pairs[n]);
      this.appear(pairs[n], pairs[n + 1]);
    }
    if (first === 0 && pairs.length === 2 * total) {
      for (const name of this.objects.keys()) if (!there.has(name)) this.vanish(name);
    }
    if (total === 0 && this.isNew) FIRST.forEach((preset, n) => this.presets.has(preset) && this.make(preset, ...SPOTS[n]));
    this.isNew = false;
  }

  appear(name, presetName) {
    const preset = this.presets.get(presetName);
    this.pending.delete(name);
    if (!preset || this.objects.has(name) || isTrial(name) || isCopy(name)) return;
    const [x, y] = this.places[name] ?? this.freeSpot();
    const object = { name, preset, body: bodyOf(preset), x, y, level: -200, seen: 0, amps: new Map(), modes: null, settings: {} };
    this.objects.set(name, object);
    this.look(object);
    if (!this.selected) this.select(name);
    this.changed();
  }

  /** Ask for an object's modes and settings. */
  async look(object) {
    const response = await fetch(`/page/object/${encodeURIComponent(object.name)}`);
    if (!response.ok) return;
    object.modes = await response.json();
    object.settings = object.modes.settings;
    object.peaks = object.modes.frequency.map((_, i) => Math.max(...object.modes.strike.map((row) => Math.abs(row[i]))));
    this.dispatchEvent(new CustomEvent("known", { detail: object.name }));
  }

  vanish(name) {
    if (!this.objects.delete(name)) return;
    if (this.selected === name) this.select(this.objects.keys().next().value ?? null);
    this.changed();
  }

  ring(name, level, pairs) {
    const object = this.objects.get(name) ?? this.objects.get(name.replace(/\.\d+(\.\d+)?$/, ""));
    if (!object) return;
    object.level = object.name === name ? level : Math.max(level, object.level);
    object.seen = performance.now();
    object.amps = new Map();
    for (let n = 0; n < pairs.length; n += 2) object.amps.set(pairs[n], 10 ** (pairs[n + 1] / 20));
  }

  /** How brightly an object shines, 0 to 1. */
  glow(object) {
    const age = (performance.now() - object.seen) / 1000;
    return Math.max(0, Math.min(1, (object.level - 40 * Math.max(0, age - 0.08) - SOFTEST) / (-8 - SOFTEST)));
  }

  freeSpot() {
    const taken = [...this.objects.values()];
    const far = ([x, y]) => Math.min(2, ...taken.map((each) => Math.hypot(each.x - x, each.y - y)));
    const spot = SPOTS.find((each) => far(each) > 0.15);
    if (spot) return spot;
    const tries = Array.from({ length: 40 }, () => [0.12 + 0.76 * Math.random(), 0.14 + 0.72 * Math.random()]);
    return tries.reduce((best, each) => (far(each) > far(best) ? each : best));
  }

  freeName(preset) {
    for (let n = 1; ; n++) {
      const name = n === 1 ? preset : `${preset}-${n}`;
      if (!this.objects.has(name) && !this.pending.has(name)) return name;
    }
  }

  make(preset, x, y, settings = {}) {
    const name = this.freeName(preset);
    this.pending.add(name);
    setTimeout(() => this.pending.delete(name), 3000);
    if (x !== undefined) this.place(name, x, y);
    this.link.send("/object/new", name, preset, ...Object.entries(settings).flat());
    return name;
  }

  add(preset, x, y) {
    const name = this.make(preset, x, y);
    this.did(() => this.link.send(`/object/${name}/free`, 1));
    this.selectSoon = name;
    return name;
  }

  remove(name) {
    const { preset, x, y, settings } = this.objects.get(name);
    this.link.send(`/object/${name}/free`, 1);
    this.did(() => this.make(preset.name, x, y, settings));
  }

  /** Let a preset be heard without putting it on the table. */
  hear(presetName) {
    const name = `try~${this.link.client.slice(0, 6)}-${++this.trials}`;
    const { velocity, position } = this.presets.get(presetName);
    this.link.send("/object/new", name, presetName);
    this.link.send(`/object/${name}/impact`, velocity, position);
    this.link.send(`/object/${name}/free`);
  }

  set(name, key, value, remember = true) {
    const object = this.objects.get(name);
    if (!object) return;
    const before = object.settings[key];
    object.settings[key] = value;
    this.link.steer(`/object/${name}/${key}`, value);
    if (remember && before !== undefined) this.did(() => { this.set(name, key, before, false); this.select(name); });
  }

  place(name, x, y) {
    const at = [x, y].map((each) => Math.min(0.97, Math.max(0.03, each)));
    this.places[name] = at;
    const object = this.objects.get(name);
    if (object) [object.x, object.y] = at;
  }

  /** Keep where things lie; `from`: where the object lay before it was moved. */
  moved(name, from) {
    localStorage.setItem(KEPT, JSON.stringify(this.places));
    if (from) this.did(() => { this.place(name, ...from); this.changed(); });
    this.changed();
  }

  select(name) {
    this.selected = name;
    this.dispatchEvent(new CustomEvent("selected", { detail: name }));
  }

  /** Select an object, unless it is selected: its controls stay as they are. */
  choose(name) {
    if (this.selected !== name) this.select(name);
  }

  did(undo) {
    this.done.push(undo);
    if (this.done.length > 200) this.done.shift();
    this.dispatchEvent(new Event("done"));
  }

  undo() {
    this.done.pop()?.();
    this.dispatchEvent(new Event("done"));
  }

  changed() {
    if (this.selectSoon && this.objects.has(this.selectSoon)) {
      this.select(this.selectSoon);
      this.selectSoon = null;
    }
    this.dispatchEvent(new Event("changed"));
  }
}
