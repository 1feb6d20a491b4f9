// A baked scene in the engine's memory: its words and commands at their samples, and messages while it plays.

import { Bodies, STACK, aligned } from "./bodies.js";
import { Messages, NOW } from "./messages.js";

const BLOCK = 4096; // most frames at once
const GRID = 256; // to a sample

const BEGIN = 0, MAY_START = 1, MAY_WRITE = 2, WRONG_WORD = 3, WRONG_RECORD = 4; // questions to the engine: admission.py

/** A whole number of a scene's map, expected to lie between others. */
const whole = (value, name, low, high) => {
  if (Number.isInteger(value) && value >= low && value <= high) return value;
  throw new Error(`${name} = ${value}: expected a whole number, ${low} to ${high}`);
};

export class Scene {
  /** module: the engine; map and data: those of a baked scene; tracker: of its bodies, if it has any. An Error says that they hold what no engine can take. */
  constructor(module, map, data, tracker) {
    Object.assign(this, { map, data });
    this.expectSizes();
    const out = aligned(map.data_end) + STACK;
    this.times = aligned(out + 4 * BLOCK * map.channels);
    this.command = aligned(this.times + 24 + 8 * map.touching.changes);
    this.base = aligned(this.command + map.command.size);
    this.out = out;
    this.memory = new WebAssembly.Memory({ initial: Math.ceil((this.base + map.size) / 65536) });
    const stack = new WebAssembly.Global({ value: "i32", mutable: true }, out);
    const env = { __linear_memory: this.memory, __stack_pointer: stack };
    this.engine = new WebAssembly.Instance(module, { env }).exports;
    this.bytes = new Uint8Array(this.memory.buffer);
    this.view = new DataView(this.memory.buffer);
    this.sound = new Float32Array(this.memory.buffer, out, BLOCK * map.channels);
    this.expectBatches();
    this.expectObjects();
    this.messages = new Messages(this);
    if (tracker) this.messages.bodies = new Bodies(this, tracker);
  }

  expectSizes() {
    const { state, quantum, rates, ...map } = this.map;
    whole(map.size, "size", state.plates, state.most);
    whole(map.size % 8, "size % 8", 0, 0);
    whole(map.channels, "channels", 1, state.most_channels);
    whole(map.sensors, "sensors", 0, map.channels - 1);
    whole(map.frames, "frames", 0, Number.MAX_SAFE_INTEGER);
    whole(whole(map.delay, "delay", 0, quantum) % quantum, "delay % quantum", 0, 0);
    whole(map.pulses.length, "tables of pulses", 0, map.size > state.values ? state.most_pulses : 0);
    if (!(map.rate >= rates[0] && map.rate <= rates[1])) throw new Error(`rate = ${map.rate}: expected ${rates[0]} to ${rates[1]}`);
  }

  /** What each batch brings is what the engine can take, after those before it. */
  expectBatches() {
    const { map, data } = this;
    const { state, command: { size } } = map;
    const expectRecords = () => {
      const values = Math.max(0, (map.size - state.values) / 4);
      const wrong = this.ask(WRONG_RECORD, values, map.size >= state.pulses ? 1 : 0);
      if (wrong >= 0) throw new Error(`record ${wrong} of plates, strikers and pulses: it does not fit itself`);
    };
    this.beginMemory();
    this.runs(map.start, MAY_START, true);
    expectRecords();
    let before = 0;
    for (const batch of map.batches) {
      const [at, , commands, count, firstTable, endTable] = batch;
      before = whole(at, "a batch's sample", before, Number.MAX_SAFE_INTEGER);
      whole(commands, "a batch's commands", 0, data.byteLength);
      whole(count, "a batch's number of commands", 0, Math.floor((data.byteLength - commands) / size));
      whole(endTable, "a batch's last table", whole(firstTable, "a batch's first table", 0, map.tables.length), map.tables.length);
      this.write(batch, true);
      expectRecords();
      for (let n = 0; n < count; n++) this.expectCommand(this.laid(commands + n * size));
    }
  }

  /** What is said of objects is what a batch makes. */
  expectObjects() {
    const { objects, presets, batches, kinds, command: { size, fields } } = this.map;
    for (const [name, each] of Object.entries(objects)) {
      const [, , commands, count] = batches[whole(each.batch, "an object's batch", 0, batches.length - 1)];
      const last = commands + (count - 1) * size;
      whole((whole(each.made, "an object's command", commands, last) - commands) % size, "an object's place in its batch", 0, 0);
      const view = new DataView(this.laid(each.made).buffer);
      const said = (field) => Number(view.getBigInt64(fields[field][0], true));
      whole(said("kind"), `what makes ${name}`, kinds.NEW, kinds.NEW);
      for (const field of ["slot", "serial"]) whole(each[field], `${name}'s ${field}`, said(field), said(field));
      whole(each.preset, "an object's preset", 0, presets.length - 1);
      if (!(each.pitch >= 0 && each.pitch <= 1e6)) throw new Error(`${name}: pitch = ${each.pitch}: expected 0 to 1e6`);
    }
  }

  /** The engine's answer to a question about its memory. */
  ask(question, first = 0, count = 0) {
    return Number(this.engine.ask(this.base, BigInt(question), BigInt(first), BigInt(count)));
  }

  /** The word by which a command is none for the engine, -1 if that may take it. */
  judge(bytes) {
    this.bytes.set(bytes, this.command);
    return Number(this.engine.judge(this.base, this.command, BigInt(this.map.pulses.length)));
  }

  /** An Error says by which of its fields a command is none for the engine. */
  expectCommand(bytes) {
    const wrong = this.judge(bytes);
    if (wrong < 0) return;
    const [name, [place, isWhole]] = Object.entries(this.map.command.fields).find(([, [at]]) => at === 8 * wrong) ?? [`word ${wrong}`, [8 * wrong, 1]];
    const view = new DataView(bytes.buffer);
    throw new Error(`a command's ${name} = ${isWhole ? view.getBigInt64(place, true) : view.getFloat64(place, true)}: none that the engine can take`);
  }

  /** The bytes of a command of the file, for an object whose modes are copied to others; null if it cannot be. */
  copied(made, to, changes) {
    this.bytes.set(this.laid(made), this.command);
    new Float64Array(this.memory.buffer, this.times + 24, changes.length).set(changes);
    const end = this.engine.copy(this.base, this.command, BigInt(to), this.times + 24);
    return end ? this.bytes.slice(this.command, this.command + this.map.command.size) : null;
  }

  /** Make the engine's memory one in which nothing has been yet. */
  beginMemory() {
    const { map: { state, rate, channels, sensors, delay, size }, base } = this;
    this.bytes.fill(0, base, base + size);
    this.ask(BEGIN);
    this.view.setFloat64(base + state.rate, rate, true);
    for (const [name, value] of Object.entries({ channels: channels - sensors, sensors, delay })) {
      this.view.setBigInt64(base + state[name], BigInt(value), true);
    }
  }

  /** Begin anew: with the score from its first line on, or with all its objects there at once and nothing else. */
  load(live = false) {
    const { map, base } = this;
    this.beginMemory();
    this.runs(map.start, MAY_START);
    map.pulses.forEach((_, number) => this.engine.make_pulses(base, BigInt(number)));
    this.next = this.refused = 0;
    this.live = live;
    this.messages.begin();
    if (live) this.makeAll();
    this.computed = 0;
    for (let left = map.delay; left > 0; ) left -= this.compute(left); // silence that the limiter begins with
  }

  /** All objects that stay where they were made, as they were made, and the engine as the first lines have it. */
  makeAll() {
    const { map } = this;
    for (const batch of map.batches) this.write(batch);
    const [first] = map.batches;
    if (first) {
      for (let n = 0; n < first[3]; n++) {
        const at = first[2] + n * map.command.size;
        if (this.messages.isOfEngine(at)) this.push(at);
      }
    }
    for (const each of Object.values(map.objects)) if (each.stays) this.push(each.made, NOW);
    this.next = map.batches.length;
  }

  /** Write a batch's words and tables of mode shapes into the engine's memory, where nothing uses it; expects: or an Error. */
  write([, runs, , , firstTable, endTable], expects = false) {
    this.runs(runs, MAY_WRITE, expects);
    for (const [first, values] of this.map.tables.slice(firstTable, endTable)) {
      this.put(first, new Uint8Array(values.buffer), MAY_WRITE, expects);
    }
  }

  /** Write runs of words into the engine's memory, as `write` does. */
  runs(at, question, expects = false) {
    whole(at % 8, "a place of runs % 8", 0, 0);
    whole(at, "a place of runs", 0, this.data.byteLength - 8);
    const heads = new Uint32Array(this.data, at);
    const count = whole(heads[0], "a number of runs", 0, (this.data.byteLength - at) / 8 - 1);
    let words = at + 8 + 8 * count;
    for (let n = 0; n < count; n++) {
      const size = whole(8 * heads[3 + 2 * n], "bytes of a run", 0, this.data.byteLength - words);
      this.put(heads[2 + 2 * n], new Uint8Array(this.data, words, size), question, expects);
      words += size;
    }
  }

  /** Write words into the engine's memory, from one on, as `write` does. */
  put(first, bytes, question, expects) {
    const count = bytes.length / 8;
    let wrong = Number.isInteger(first) && first >= 0 && 8 * (first + count) <= this.map.size ? this.ask(question, first, count) : first;
    if (wrong === -1) {
      this.bytes.set(bytes, this.base + 8 * first);
      if (expects) wrong = this.ask(WRONG_WORD, first, count);
    }
    if (expects && wrong !== -1) throw new Error(`word ${wrong} of the memory: none that a scene has there`);
  }

  whole(place) {
    return Number(this.view.getBigInt64(this.base + place, true));
  }

  /** The bytes of a command of the file. */
  laid(at) {
    return new Uint8Array(this.data.slice(at, at + this.map.command.size));
  }

  /** Send a command of the file, at its own time if no other is given; count it if the engine can't take it now. */
  push(at, time) {
    const bytes = this.laid(at);
    if (time !== undefined) new DataView(bytes.buffer).setFloat64(this.map.command.fields.time[0], time, true);
    if (this.judge(bytes) < 0 && this.room > 0) this.hand(bytes);
    else this.refused++;
  }

  /** Commands that the engine has room for. */
  get room() {
    const { state } = this.map;
    return state.ring - this.whole(state.written) + this.whole(state.read);
  }

  /** An Error says that there is no room for so many commands. */
  expectRoom(count) {
    if (this.room < count) throw new Error(`no capacity for another command: ${this.map.state.ring - this.room} wait`);
  }

  /** Send the bytes of a command. An Error says that there is no room, or that the engine can't take it. */
  send(bytes) {
    this.expectRoom(1);
    this.expectCommand(bytes);
    this.hand(bytes);
  }

  hand(bytes) {
    const { state, command } = this.map;
    const written = this.whole(state.written);
    const entry = this.base + state.entries + (written % state.ring) * command.size;
    this.bytes.set(bytes, entry);
    this.view.setBigInt64(entry + command.fields.number[0], BigInt(written), true);
    this.view.setBigInt64(this.base + state.written, BigInt(written + 1), true);
  }

  /** The sample of a time in s: that of the engine's grid, if only rounding lies between. */
  sampleAt(time) {
    const sample = time * this.map.rate;
    const nearest = Math.floor(sample * GRID + 0.5) / GRID;
    return Math.abs(sample - nearest) <= 4 * Number.EPSILON * sample ? nearest : sample;
  }

  get position() {
    return this.whole(this.map.state.position);
  }

  /** What goes on, and what was left out so far, as `carom_state` has it in C. */
  get report() {
    const { state } = this.map;
    const [contacts, sounding, waiting, dropped, linear, late] = ["active", "sounding", "queued", "dropped", "linear", "late"].map((name) => this.whole(state[name]));
    const heard = this.view.getFloat64(this.base + state.loudest, true);
    const loudest = heard > 1e-20 ? 10 * Math.log10(heard) - 0.691 : -200;
    return { frames: this.position, contacts, sounding, waiting, dropped, loudest, linear, late, refused: this.refused };
  }

  /** Give the engine what is due, and compute at most so many frames; how many are in `sound` now. */
  compute(frames) {
    const { batches, command } = this.map;
    const position = this.position;
    while (this.next < batches.length && batches[this.next][0] <= position) {
      const batch = batches[this.next++];
      const [, , commands, count] = batch;
      this.write(batch);
      for (let n = 0; n < count; n++) this.push(commands + n * command.size);
    }
    const due = this.next < batches.length ? batches[this.next][0] : Infinity;
    const now = Math.min(frames, due - this.computed, BLOCK);
    this.engine.callback(0, this.out, BigInt(now), this.times, 0n, this.base);
    this.computed += now;
    return now;
  }
}
