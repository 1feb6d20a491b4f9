// Contacts of a game: bodies, how they move and touch, and what the tracker makes of a frame.

export const STACK = 1 << 18; // bytes
const ROOM = 1024; // bytes for the numbers of a call
const WIDTHS = { move: 14, touch: 16 }; // numbers of what a frame reports

export const aligned = (at) => Math.ceil(at / 64) * 64;

export class Bodies {
  /** tracker: its module, which says where its data end. */
  constructor(scene, { module, end }) {
    const { size } = scene.map.touching;
    this.scene = scene;
    this.numbers = aligned(end) + STACK;
    this.base = aligned(this.numbers + Math.max(ROOM, scene.map.command.size));
    this.memory = new WebAssembly.Memory({ initial: Math.ceil((this.base + size) / 65536) });
    const stack = new WebAssembly.Global({ value: "i32", mutable: true }, this.numbers);
    this.tracker = new WebAssembly.Instance(module, { env: { __linear_memory: this.memory, __stack_pointer: stack } }).exports;
    this.bytes = new Uint8Array(this.memory.buffer);
  }

  /** Put numbers where a call finds them. */
  put(numbers) {
    new Float64Array(this.memory.buffer, this.numbers, numbers.length).set(numbers);
    return this.numbers;
  }

  /** Begin the bodies of the scene's score. */
  begin(objects) {
    const { bodies, laws, slides, rate, touching, command } = this.scene.map;
    this.bytes.fill(0, this.base, this.base + touching.size);
    this.tracker.begin(BigInt(this.base), rate, BigInt(touching.rolls));
    const materials = Math.round(Math.sqrt(laws.length));
    laws.forEach((law, n) => this.tracker.set_law(this.base, BigInt(Math.floor(n / materials)), BigInt(n % materials), this.put(law.slice(0, 4))));
    slides.forEach(([least, at], n) => {
      if (!(at >= 0 && at % 8 === 0 && at + command.size <= this.scene.data.byteLength)) return;
      this.bytes.set(this.scene.laid(at), this.numbers);
      this.tracker.set_slide(this.base, BigInt(n), least, this.numbers);
    });
    this.silent = {};
    for (const [name, row] of Object.entries(bodies)) {
      const number = this.row(row, [0, 0, 0, -1], objects[name] ?? { slot: 0, serial: 0 });
      if (objects[name]) Object.assign(objects[name], { body: number, row });
      else this.silent[name] = number;
    }
  }

  /** Make a body by its row; its number, below 0 if there is none. */
  row(row, change, { slot, serial }) {
    if (row.length !== this.scene.map.touching.body) return -2;
    const at = this.put([...row, ...change]);
    return Number(this.tracker.make_body(this.base, at, at + 8 * row.length, BigInt(slot), BigInt(serial)));
  }

  /** Make the body of an object that is made like another. */
  make(object, change) {
    return this.row(object.row, change, object);
  }

  free(body) {
    this.tracker.free_body(this.base, BigInt(body));
  }

  /** The number of a body. */
  number(name) {
    const { objects } = this.scene.messages;
    const body = Object.hasOwn(objects, name) ? objects[name].body : Object.hasOwn(this.silent, name) ? this.silent[name] : -1;
    if (!(body >= 0)) throw new Error(`${name}: no such body; expected one that /world/body makes in the score, or one made like it`);
    return body;
  }

  /** Take a frame: `moves` and `touches` as carom.js has them. */
  frame({ seconds, moves, touches, listener, share }, load) {
    if (share !== undefined && !this.tracker.govern(this.base, share)) throw new Error(`share = ${share}: expected 0 to 1`);
    if (listener && !(listener.length === 6 && this.tracker.listen(this.base, this.put(listener)))) throw new Error(`listener ${listener}: expected a place, and a direction`);
    const { scene } = this;
    const { ring, queued } = scene.map.state;
    scene.expectRoom(ring / 2); // before the tracker takes the frame: else the end of a slide may get lost
    const wrong = [...this.report("move", moves), ...this.report("touch", touches)];
    const waiting = scene.whole(queued) + ring - scene.room;
    const count = Number(this.tracker.end_frame(this.base, seconds, BigInt(scene.position), BigInt(waiting), load));
    if (count < 0) throw new Error(`seconds = ${seconds}: expected 1e-6 to 1e6`);
    scene.expectRoom(count);
    for (let n = 0; n < count; n++) {
      const at = this.base + Number(this.tracker.command_at(this.base, BigInt(n)));
      const bytes = this.bytes.slice(at, at + scene.map.command.size);
      if (scene.judge(bytes) < 0) scene.hand(bytes);
      else scene.refused++;
    }
    if (wrong.length) throw new Error(wrong[0]);
  }

  /** Report moves or touches: rows that begin with one name of a body, or two; why those that cannot be are left out. */
  report(what, rows) {
    const wrong = [];
    const names = what === "touch" ? 2 : 1;
    for (const row of rows) {
      try {
        const numbers = row.map((each, n) => (n < names ? this.number(each) : each));
        const isWhole = numbers.length === WIDTHS[what] && Number(this.tracker[what](this.base, this.put(numbers)));
        if (!isWhole) throw new Error(`${what} ${row.slice(0, names).join(", ")}: expected numbers that can be, and lengths of 1`);
      } catch (error) {
        wrong.push(error.message);
      }
    }
    return wrong;
  }

  /** What happened so far, as `carom_contacts` has it in C. */
  get contacts() {
    this.tracker.report(this.base, this.numbers);
    const [blows, faint, slides, leftOut, loud, crowded, bodies] = new Float64Array(this.memory.buffer, this.numbers, 7);
    return { blows, faint, slides, leftOut, loudest: loud > 0 ? 20 * Math.log10(loud / 20e-6) : -200, crowded, bodies };
  }
}
