// The objects on the table: what the server has, where they lie, what was done last.

import { bodyOf } from "./bodies.js";
import { read, write } from "./tables.js";

/** The share of the table's sides at their ends where no object's middle lies. */
export const EDGE = 0.03;

const FIRST = ["church-bell", "wine-glass", "steel-plate", "wood-board", "singing-bowl", "marimba-bar"];
const SOFTEST = -72; // dB at which an object is dark
const PLACES = "carom-places";
const TABLE = "carom-table"; // as it was last, for a server that has lost it
const LATER = 300; // ms after a change in which others may come, until the table is kept

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
    this.copies = new Set(); // names of objects that notes are played on
    this.selected = null;
    this.done = [];
    this.pending = new Map(); // by name, objects that were asked for
    this.places = JSON.parse(localStorage.getItem(PLACES) ?? "{}");
    this.room = null; // the table, which knows where there is room
    this.listener = null; // who hears objects from where they lie
    this.trials = 0;
    this.isKnown = false; // whether it is known what the server has
    this.restored = new Set(); // names of objects that were made again: another page may have been faster
    link.on("/objects.reply", (first, total, ...pairs) => this.meet(first, total, pairs));
    link.on("/object.added", (name, preset) => this.appear(name, preset));
    link.on("/object.removed", (name) => this.vanish(name));
    link.on("/modes", (name, level, ...pairs) => this.ring(name, level, pairs));
    link.addEventListener("open", () => {
      this.isKnown = false;
      link.send("/notify", 3);
      link.send("/objects");
    });
    for (const type of ["changed", "known", "set"]) this.addEventListener(type, () => this.keepSoon());
  }

  /** What the server has as the page comes to it; a server without objects gets the table that was here last. */
  meet(first, total, pairs) {
    const there = new Set();
    for (let n = 0; n < pairs.length; n += 2) {
      there.add(pairs[n]);
      this.appear(pairs[n], pairs[n + 1], true);
    }
    if (first === 0 && pairs.length === 2 * total) {
      for (const name of this.objects.keys()) if (!there.has(name)) this.vanish(name);
    }
    const comes = !this.isKnown;
    this.isKnown = true;
    if (total === 0 && comes) this.restore();
    this.changed();
  }

  restore() {
    const kept = localStorage.getItem(TABLE);
    const objects = kept === null ? this.first() : read(kept).objects;
    this.restored = new Set(objects.map(({ name }) => name));
    this.lay(objects);
  }

  /** Objects to begin with. */
  first() {
    return FIRST.filter((preset) => this.presets.has(preset)).map((preset) => ({ name: preset, preset, keys: {} }));
  }

  appear(name, presetName, isHere = false) {
    const preset = this.presets.get(presetName);
    const { near, exact = isHere } = this.pending.get(name) ?? {};
    this.pending.delete(name);
    if (isCopy(name)) this.copies.add(name);
    if (!preset || this.objects.has(name) || isTrial(name) || isCopy(name)) return;
    const body = bodyOf(preset);
    const place = this.places[name];
    const [x, y] = exact && place ? place : this.room.freeSpot(name, body, place ?? near);
    const object = { name, preset, body, material: preset.material, level: -200, seen: 0, amps: new Map(), modes: null, settings: {}, macros: {}, made: {} };
    this.objects.set(name, object);
    this.place(name, x, y);
    this.look(object);
    if (!this.selected) this.select(name);
    this.changed();
  }

  /** Ask for an object's modes and settings, once the server has them as they were set here. */
  async look(object, tell = true) {
    await this.link.sync();
    const response = await fetch(`/page/object/${encodeURIComponent(object.name)}`);
    if (!response.ok) return;
    object.modes = await response.json();
    object.settings = object.modes.settings;
    object.macros = object.modes.macros;
    object.made = object.modes.made;
    object.material = object.modes.material;
    object.body = bodyOf({ ...object.preset, ...object.modes, name: object.preset.name, view: object.body.view });
    object.peaks = object.modes.frequency.map((_, i) => Math.max(...(object.modes.shapes ?? object.modes.strike).map((row) => Math.abs(row[i]))));
    if (tell) this.dispatchEvent(new CustomEvent("known", { detail: object.name }));
  }

  vanish(name) {
    this.copies.delete(name);
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

  freeName(preset) {
    for (let n = 1; ; n++) {
      const name = n === 1 ? preset : `${preset}-${n}`;
      if (!this.objects.has(name) && !this.pending.has(name)) return name;
    }
  }

  /** Ask for an object; `keys`: of /object/new; `where`: near which place it should lie, if there is room. */
  make(name, preset, keys = {}, where = {}, macros = {}) {
    this.pending.set(name, where);
    setTimeout(() => this.pending.delete(name), 3000);
    this.link.send("/object/new", name, preset, ...Object.entries(keys).flat());
    for (const [macro, value] of Object.entries(macros)) this.link.send(`/object/${name}/macro/${macro}`, value);
  }

  add(preset, x, y) {
    const name = this.freeName(preset);
    delete this.places[name]; // a namesake's
    this.make(name, preset, {}, x === undefined ? {} : { near: [x, y] });
    this.did(() => this.link.send(`/object/${name}/free`, 1));
    this.selectSoon = name;
    return name;
  }

  remove(name) {
    const { preset, keys, macros } = this.entry(this.objects.get(name));
    this.link.send(`/object/${name}/free`, 1);
    this.did(() => this.make(name, preset, keys, {}, macros));
  }

  /** An object as a table keeps it. */
  entry({ name, preset, made, settings, macros, x, y }) {
    const usual = new Map(this.catalogue.settings.map((each) => [each.name, each.default]));
    const set = Object.entries(settings).filter(([key, value]) => value !== usual.get(key) || key in made);
    const turned = this.catalogue.macros.map((each) => [each.name, macros[each.name] ?? each.default]).filter(([, value], n) => value !== this.catalogue.macros[n].default);
    return { name, preset: preset.name, keys: { ...made, ...Object.fromEntries(set) }, macros: Object.fromEntries(turned), x, y, velocity: preset.velocity, position: preset.position };
  }

  /** The table as a score. */
  text(title) {
    return write(title, [...this.objects.values()].map((object) => this.entry(object)), this.listener.lines);
  }

  /** The same, with what others have set meanwhile. */
  async freshText(title) {
    await Promise.all([...this.objects.values()].map((object) => this.look(object)));
    return this.text(title);
  }

  keepSoon() {
    clearTimeout(this.keeping);
    this.keeping = setTimeout(() => this.keep(), LATER);
  }

  /** Keep the table for a server that will have lost it. */
  keep() {
    if (this.pending.size) this.keepSoon();
    else if (this.isKnown && this.link.isOpen) localStorage.setItem(TABLE, this.text("as it was last"));
  }

  /** Lay a table that was kept, with its listener, in place of what is there. */
  open({ objects, listener }) {
    this.replace(objects);
    this.listener.be(listener);
  }

  /** Lay objects in place of all that are there. */
  replace(objects) {
    const before = [...this.objects.values()].map((object) => this.entry(object));
    for (const name of [...this.objects.keys()]) {
      this.link.send(`/object/${name}/free`, 1);
      this.vanish(name);
    }
    this.room.spread();
    this.lay(objects);
    this.link.send("/objects"); // an object that came in a namesake's place is not told
    this.did(() => this.replace(before));
  }

  lay(objects) {
    for (const { name, preset, keys, macros, x, y } of objects) {
      if (x === undefined) delete this.places[name];
      else this.place(name, x, y);
      this.make(name, preset, keys, { exact: x !== undefined }, macros);
    }
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
    this.dispatchEvent(new Event("set"));
    if (remember && before !== undefined) this.did(() => { this.set(name, key, before, false); this.select(name); });
  }

  /** Turn a macro of an object. */
  turn(name, macro, value, remember = true) {
    const object = this.objects.get(name);
    if (!object) return;
    const before = object.macros[macro];
    object.macros[macro] = value;
    this.link.steer(`/object/${name}/macro/${macro}`, value);
    this.dispatchEvent(new Event("set"));
    if (remember && before !== undefined) this.did(() => { this.turn(name, macro, before, false); this.select(name); });
  }

  /** Turn several macros of an object, which one Undo takes back. */
  turnAll(name, macros, remember = true) {
    const object = this.objects.get(name);
    if (!object) return;
    const before = { ...object.macros };
    for (const [macro, value] of Object.entries(macros)) if (value !== before[macro]) this.turn(name, macro, value, false);
    if (remember) this.did(() => this.turnAll(name, before, false));
    this.select(name);
  }

  /** Turn all macros of an object as a die falls. */
  async throwDice(object) {
    this.link.send(`/object/${object.name}/dice`);
    this.did(async () => {
      this.link.send(`/object/${object.name}/undo`);
      await this.look(object);
    });
    await this.look(object);
  }

  place(name, x, y) {
    const at = [x, y].map((each) => Number(Math.min(1 - EDGE, Math.max(EDGE, each)).toFixed(4)));
    this.places[name] = at;
    const object = this.objects.get(name);
    if (!object) return;
    [object.x, object.y] = at;
    this.dispatchEvent(new CustomEvent("placed", { detail: name }));
  }

  /** Keep where things lie; `from`: where the object lay before it was moved. */
  moved(name, from) {
    localStorage.setItem(PLACES, JSON.stringify(this.places));
    if (from) this.did(() => { this.place(name, ...from); this.changed(); });
    this.changed();
  }

  /** An object and the copies of it that notes are played on: their names. */
  namesOf({ name }) {
    return [name, ...[...this.copies].filter((each) => each.startsWith(`${name}.`))];
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
