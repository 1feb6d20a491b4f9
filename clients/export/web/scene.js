// A baked scene in the engine's memory: its words and commands at their samples, and messages while it plays.

import { Messages, NOW } from "./messages.js";

const STACK = 1 << 18; // bytes
const BLOCK = 4096; // most frames at once
const GRID = 256; // to a sample

const aligned = (at, to = 64) => Math.ceil(at / to) * to;

export class Scene {
  /** module: the engine; map and data: those of a baked scene. */
  constructor(module, map, data) {
    Object.assign(this, { map, data });
    const out = aligned(map.data_end) + STACK;
    this.times = aligned(out + 4 * BLOCK * map.channels);
    this.base = aligned(this.times + 24);
    this.out = out;
    this.memory = new WebAssembly.Memory({ initial: Math.ceil((this.base + map.state.size) / 65536) });
    const stack = new WebAssembly.Global({ value: "i32", mutable: true }, out);
    const env = { __linear_memory: this.memory, __stack_pointer: stack };
    this.engine = new WebAssembly.Instance(module, { env }).exports;
    this.bytes = new Uint8Array(this.memory.buffer);
    this.view = new DataView(this.memory.buffer);
    this.sound = new Float32Array(this.memory.buffer, out, BLOCK * map.channels);
    this.messages = new Messages(this);
  }

  /** Begin anew: with the score from its first line on, or with all its objects there at once and nothing else. */
  load(live = false) {
    const { map, base } = this;
    this.bytes.fill(0, base, base + map.state.size);
    this.runs(map.start);
    map.pulses.forEach((_, number) => this.engine.make_pulses(base, BigInt(number)));
    this.next = 0;
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

  /** Write a batch's words and tables of mode shapes into the engine's memory. */
  write([, runs, , , firstTable, endTable]) {
    this.runs(runs);
    for (const [first, values] of this.map.tables.slice(firstTable, endTable)) {
      this.bytes.set(new Uint8Array(values.buffer), this.base + 8 * first);
    }
  }

  /** Write runs of words into the engine's memory. */
  runs(at) {
    const heads = new Uint32Array(this.data, at);
    const count = heads[0];
    let words = at + 8 + 8 * count;
    for (let n = 0; n < count; n++) {
      const size = 8 * heads[3 + 2 * n];
      this.bytes.set(new Uint8Array(this.data, words, size), this.base + 8 * heads[2 + 2 * n]);
      words += size;
    }
  }

  whole(place) {
    return Number(this.view.getBigInt64(this.base + place, true));
  }

  /** Send a command of the file, at its own time if no other is given. */
  push(at, time) {
    const { size, fields } = this.map.command;
    const bytes = new Uint8Array(this.data.slice(at, at + size));
    if (time !== undefined) new DataView(bytes.buffer).setFloat64(fields.time[0], time, true);
    this.send(bytes);
  }

  /** An Error says that there is no room for so many commands. */
  expectRoom(count) {
    const { state } = this.map;
    const waiting = this.whole(state.written) - this.whole(state.read);
    if (waiting + count > state.ring) throw new Error(`no room for another command: ${waiting} wait`);
  }

  /** Send the bytes of a command. An Error says that there is no room. */
  send(bytes) {
    const { state, command } = this.map;
    const written = this.whole(state.written);
    this.expectRoom(1);
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
