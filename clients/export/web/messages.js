// Messages, as OSC has them, to the engine's commands. All that it knows of gestures, values and ranges is in the map.

const GRAVITY = 9.80665;
const APPROACH = 0.01; // m/s: how fast a pressing striker is laid on
const ANY_RADIUS = 0.01; // m: of a roll that is steered, and so has one; of an object where it touches another
const MOST_POINTS = 64; // of a list of values
const LIVE = 1 << 20; // numbers of gestures from here on are not the score's
export const NOW = -1; // the time of what is not to wait
const [A4, A4_HZ] = [69, 440];
const [SLOWEST, FASTEST] = [0.05, 5]; // m/s of the velocities 1 and 127
const NOTE = /^([A-Ga-g])(#|b|s)?(-?\d{1,2})$/;
const STEPS = { C: 0, D: 2, E: 4, F: 5, G: 7, A: 9, B: 11 };
const SIGNS = { "#": 1, s: 1, b: -1 };

export class Refused extends Error {}

const refuse = (text) => {
  throw new Refused(text);
};

/** What a table has under a name; not what all objects of JavaScript have, as `constructor`. */
const under = (table, name) => (Object.hasOwn(table, name) ? table[name] : undefined);

function inEngine({ unit }, value) {
  if (unit === "dB") return 10 ** (value / 20);
  return unit === "semitones" ? 2 ** (value / 12) : value;
}

function checked(declared, value) {
  const { name, low, high, expected, whole, words, orZero, least } = declared;
  if (words) return words.includes(String(value)) ? String(value) : refuse(`${name} = ${value}: expected one of ${words.join(", ")}`);
  if (low === undefined) return typeof value === "string" && value ? value : refuse(`${name} = ${value}: expected a name`);
  const note = typeof value === "string" && name === "note" ? value.match(NOTE) : null;
  if (note) value = 12 * (Number(note[3]) + 1) + STEPS[note[1].toUpperCase()] + (SIGNS[note[2]] ?? 0);
  const fits = typeof value === "number" && ((value >= low && value <= high) || (orZero && value === 0));
  if (!fits) refuse(`${name} = ${value}: expected ${expected}`);
  if (Math.abs(value) < least) value = 0; // too little to tell
  if (whole && !Number.isInteger(value)) refuse(`${name} = ${value}: expected a whole number`);
  return value;
}

/** The checked arguments of a message: {given, defaults}, by name. */
function parsed(address, verb, args) {
  const { required = [], optional = [], keys = [] } = verb;
  const named = Object.fromEntries([...keys, ...optional].map((each) => [each.name, each]));
  const given = {};
  const add = (declared, value) => {
    if (declared.name in given) refuse(`${declared.name} = ${value}: given twice`);
    given[declared.name] = checked(declared, value);
  };
  const rest = [...args];
  for (const each of required) rest.length ? add(each, rest.shift()) : refuse(`${each.name} is missing: ${address}`);
  for (const each of optional) {
    if (rest.length && (typeof rest[0] !== "string" || (rest.length % 2 && !under(named, rest[0])))) add(each, rest.shift());
  }
  for (let n = 0; n < rest.length; n += 2) {
    if (!under(named, rest[n])) refuse(`${rest[n]}: no such key; expected one of ${Object.keys(named).join(", ")}`);
    if (n + 1 === rest.length) refuse(`${rest[n]}: its value is missing`);
    add(named[rest[n]], rest[n + 1]);
  }
  const defaults = {};
  for (const each of Object.values(named)) if (each.default !== undefined) defaults[each.name] = each.default;
  return { given, defaults };
}

/** The points of a number that may take its time, as `/gain [0, -20] over 2`: {value, after, over, curve}. */
function points({ required: [number], keys }, args) {
  if (!args.length) refuse(`${number.name} is missing`);
  const given = {};
  for (let n = 1; n < args.length; n += 2) {
    if (!keys.some(({ name }) => name === args[n])) refuse(`${args[n]}: no such key; expected over, curve`);
    if (n + 1 === args.length) refuse(`${args[n]}: its value is missing`);
    if (args[n] in given) refuse(`${args[n]} = ${args[n + 1]}: given twice`);
    given[args[n]] = args[n + 1];
  }
  const values = [args[0]].flat();
  if (!values.length) refuse(`${number.name}: expected a number`);
  if (values.length > MOST_POINTS) refuse(`${number.name}: ${values.length} values: expected at most ${MOST_POINTS}`);
  if (values.length > 1 && !("over" in given)) refuse(`${number.name}: over is missing: expected the time of each value, s`);
  const ofEach = (declared) => {
    const found = [given[declared.name] ?? 0].flat().map((each) => checked(declared, each));
    if (found.length !== 1 && found.length !== values.length) refuse(`${declared.name}: expected one number, or ${values.length}`);
    return values.map((_, n) => found[found.length > 1 ? n : 0]);
  };
  const [over, curve] = keys.map(ofEach);
  let after = 0;
  return values.map((each, n) => {
    const value = inEngine(number, checked(number, each));
    const point = { value, "ramp.after": after, "ramp.over": over[n], "ramp.curve": curve[n] };
    after += over[n];
    return point;
  });
}

/** The arguments of a message, or null: at an address without any a button acts as it is pressed, and not as it is let go. */
function asked({ changes, required, optional, keys }, args) {
  if (changes || required || optional || keys || args.length !== 1) return args;
  if ([0, false].includes(args[0])) return null;
  return [1, true, null].includes(args[0]) ? [] : args;
}

export class Messages {
  constructor(scene) {
    this.scene = scene;
    this.map = scene.map;
    this.file = new DataView(scene.data);
  }

  /** Forget what was played. */
  begin() {
    const { objects } = this.map;
    this.objects = Object.fromEntries(Object.entries(objects).map(([name, each]) => [name, { ...each, body: -1 }]));
    this.freed = [];
    this.running = new Map(); // by id: {number, addresses}, those of all that go on
    this.made = 0;
    this.endsRead = 0;
    const handles = Object.values(objects);
    this.serial = Math.max(0, ...handles.map(({ serial }) => serial));
    this.slot = Math.max(-1, ...handles.map(({ slot }) => slot));
    this.mode = 0;
    for (const each of handles) this.mode = Math.max(this.mode, this.said(each.made, "layout.first") + this.said(each.made, "layout.size"));
    this.number = LIVE;
    this.bodies?.begin(this.objects);
  }

  /** A field of a command in the file. */
  said(at, name) {
    const [place, whole] = this.map.command.fields[name];
    return whole ? Number(this.file.getBigInt64(at + place, true)) : this.file.getFloat64(at + place, true);
  }

  /** True if a command of the file is about no object and no gesture. */
  isOfEngine(at) {
    const { kinds } = this.map;
    return ["ACCURACY", "QUALITY", "GAIN", "LIMITER", "HEADROOM", "BUDGET", "BANK"].some((name) => kinds[name] === this.said(at, "kind"));
  }

  /** Carry out a message at a sample, or now; the id of a gesture that it begins. Refused says why not. */
  perform(address, args, time = NOW) {
    if (typeof address !== "string") refuse(`${address}: expected an address, as /object/NAME/impact`);
    if (!Number.isFinite(time)) refuse(`${time}: expected a time in s`);
    const parts = address.split("/");
    if (address === "/object/new") return this.make(parsed(address, this.map.verbs[address], args).given, time);
    const [, group, target, action] = parts;
    if (action === "macro") refuse(`${address}: pages turn no macros live; expected them in the score, or an export for C or a plug-in`);
    const template = parts.length === 4 ? `/${group}/${group === "object" ? "NAME" : "ID"}/${action}` : address;
    const verb = under(this.map.verbs, template) ?? refuse(`${address}: not in an exported scene; expected one of ${Object.keys(this.map.verbs).join(", ")}`);
    args = asked(verb, args);
    if (args === null) return undefined;
    if (group === "gesture") return this.steer(verb, target, action, args, time);
    if (group !== "object") return this.engine(verb, address, args, time);
    const object = under(this.objects, target) ?? refuse(`${target}: no such object; there are ${Object.keys(this.objects).join(", ")}`);
    if (action in this.map.gestures) return this.gesture(verb, target, object, action, args, time);
    if (action === "note") return this.note(verb, target, object, address, args, time);
    const about = { slot: object.slot, serial: object.serial };
    if (verb.changes) {
      this.change({ time, kind: "SET", parameter: this.map.settings[action], ...about }, points(verb, args));
      if (typeof args[0] === "number") object.settings = { ...object.settings, [action]: args[0] };
    } else {
      this.send({ time, kind: "FREE", value: parsed(address, verb, args).given.at_once ?? 0, ...about });
      this.leave(object, time);
      delete this.objects[target];
    }
  }

  engine(verb, address, args, time) {
    const kind = address.slice(1).toUpperCase();
    if (verb.changes) return this.change({ time, kind }, points(verb, args));
    const [word] = Object.values(parsed(address, verb, args).given);
    if (kind === "ACCURACY") this.send({ time, kind, value: this.map.levels[word] });
    else if (kind === "BANK") this.send({ time, kind, value: this.map.forms.indexOf(word) });
    else if (kind === "LIMITER") this.send({ time, kind, value: ["on", "1"].includes(word) ? 1 : 0 });
    else this.send({ time, kind, value: word ?? 0 });
  }

  steer(verb, id, action, args, time) {
    this.collect();
    const { number, addresses } = this.running.get(id) ?? refuse(`${id}: no such gesture is running`);
    const kinds = addresses.map((each) => each.split("/")[1]);
    const has = action === "stop" || kinds.some((kind) => this.map.gestures[kind].steerable.includes(action));
    if (!has) refuse(`${id}: what goes on (${kinds.join(", ")}) has no ${action}`);
    if (action === "stop") this.send({ time, kind: "STOP", gesture: number });
    else this.change({ time, kind: "STEER", gesture: number, parameter: this.map.steerable[action] }, points(verb, args));
  }

  /** Learn which gestures have ended. */
  collect() {
    const { state } = this.map;
    const { scene } = this;
    const count = scene.whole(state.ended);
    for (let n = Math.max(this.endsRead, count - state.most_ended); n < count; n++) {
      const [number, end] = [0, 8].map((at) => scene.whole(state.ends + at + 16 * (n % state.most_ended)));
      for (const [id, { number: own, addresses }] of this.running) {
        if (own !== number) continue;
        if (end === this.map.joined) addresses.pop();
        else addresses.shift();
        if (!addresses.length) this.running.delete(id);
      }
    }
    this.endsRead = count;
  }

  /** The values of a gesture's message, with what the object's preset says of what it leaves out. */
  completed(verb, object, gesture, action, args) {
    const { given, defaults } = parsed(action, verb, args);
    const preset = this.map.presets[object.preset];
    const { argument, instead } = this.map.gestures[action];
    if (argument in given && instead in given) refuse(`${argument}, ${instead}: expected one of the two`);
    const usual = preset.usual[action];
    const strikes = "striker" in given || "by" in given || ("mass" in given && "stiffness" in given);
    if (usual) {
      if (usual.surface) given.surface ??= usual.surface;
      if (!strikes) given.striker = usual.striker;
      Object.assign(defaults, strikes ? { [argument]: usual.numbers[argument] } : usual.numbers);
    } else if (argument === "velocity") defaults.velocity = preset.velocity;
    if (instead in given) defaults[argument] = 0;
    if (!(argument in given) && !(argument in defaults)) refuse(`${argument} is missing, and ${preset.name} has none`);
    return { given, defaults, preset, value: (name) => given[name] ?? defaults[name] };
  }

  /** Begin a gesture, or steer the one along a surface that goes on with its id. */
  gesture(verb, target, object, action, args, time) {
    this.collect();
    const gesture = this.map.gestures[action];
    const to = this.completed(verb, object, gesture, action, args);
    const { given, defaults, preset, value } = to;
    const by = this.striking(given.by, object);
    const name = given.striker ?? preset.striker;
    const striker = under(this.map.strikers, name) ?? refuse(`striker = ${name}: no such striker; expected one of ${Object.keys(this.map.strikers).join(", ")}`);
    const radius = given.by_radius ?? given.radius ?? ANY_RADIUS;
    const byMaterials = by && !("striker" in given);
    const surface = gesture.along ? this.surface(given.surface ?? "wood") : null;
    const law = this.law(given, object, striker, by, byMaterials ? radius : 0, surface);
    const motion = Object.fromEntries(gesture.own.map((key) => [key, given[key] ?? defaults[key] ?? 0]));
    if (!gesture.falls) motion[gesture.argument] = value(gesture.argument);
    if (gesture.held) motion.velocity = APPROACH;
    if (gesture.falls) this.fall(motion, value);
    const instead = given[gesture.instead] ?? 0;
    const most = gesture.most * law.mass;
    if (instead > most) refuse(`impulse = ${instead}: expected at most ${most} N s of a striker of ${law.mass} kg`);
    const moves = motion[gesture.falls ? "velocity" : gesture.argument] > 0 || instead > 0;
    if (!moves && !gesture.lasts) return undefined;
    if (gesture.swarms) motion.pulses = this.pulses(gesture, law, given);
    const id = given.id ?? (gesture.along ? target : gesture.single ? undefined : `${target}-${++this.made}`);
    const goesOn = gesture.along && this.goesOn(id, `${target}/${action}`);
    if (gesture.slips) this.slip(motion, to, byMaterials ? { ...this.map.dry, radius } : striker.sliding, law, target);
    if (gesture.rolls) {
      motion.radius = given.radius ?? defaults.radius ?? (byMaterials ? radius : striker.radius);
      if (!motion.radius && moves && !goesOn) refuse("radius is missing: the striker is no ball; expected its radius (m)");
      motion.radius ||= ANY_RADIUS;
    }
    if (gesture.along && moves && !goesOn) {
      const least = surface.least * motion.roughness;
      if (motion.radius < least) refuse(`radius = ${motion.radius}: expected at least ${least} m on this surface`);
    }
    const number = id === undefined ? 0 : this.start(id, `${target}/${action}`);
    if (gesture.seeded) motion.seed = given.seed ?? number;
    const isPoint = !("striker" in given) && "mass" in given && "stiffness" in given;
    const [sound, serial] = by || isPoint || gesture.drops ? [0, 0] : gesture.slips ? striker.held : striker.sound;
    const values = {
      ...gesture.values, ...motion, sound, sound_serial: serial, ...law,
      position: given.position ?? preset.position, gain: inEngine({ unit: "dB" }, value("gain")),
      by_position: given.by_position ?? (by ? this.map.presets[by.preset].position : 0),
    };
    const command = { time, kind: "GESTURE", what: gesture.number, gesture: number, slot: object.slot, serial: object.serial };
    if (by) Object.assign(command, { by_slot: by.slot, by_serial: by.serial });
    for (const [key, each] of Object.entries(values)) if (`values.${key}` in this.map.command.fields) command[`values.${key}`] = each;
    if (gesture.along) this.along(command, gesture, given, surface);
    this.send(command);
    return id;
  }

  /** The number of the table of a swarm's blows. */
  pulses(gesture, law, given) {
    if (given.by !== undefined) refuse(`by = ${given.by}: grains hit it; expected a striker`);
    const exponent = gesture.drops ? 0 : law.exponent;
    const table = this.map.pulses.find(([each]) => each === exponent);
    return table?.[1] ?? refuse(`exponent = ${exponent}: expected a gesture of small blows with it in the scene's score`);
  }

  along(command, gesture, given, { profile }) {
    const { steerable, command: { fields } } = this.map;
    command.given = gesture.steerable.filter((name) => name in given).reduce((sum, name) => sum + 2 ** steerable[name], 0);
    Object.keys(fields).filter((name) => name.startsWith("surface.")).forEach((name, n) => (command[name] = profile[n]));
  }

  surface(name) {
    return under(this.map.surfaces, name) ?? refuse(`surface = ${name}: no such surface; expected one of ${Object.keys(this.map.surfaces).join(", ")}`);
  }

  striking(name, object) {
    if (name === undefined) return null;
    const by = under(this.objects, name);
    return by && by !== object ? by : refuse(`by = ${name}: expected another object; there are ${Object.keys(this.objects).join(", ")}`);
  }

  /** The contact law of a gesture: its striker's, or that of two materials, and the values that are given. */
  law(given, object, striker, by, radius, surface) {
    const [mass, stiffness, dissipation, exponent, restitution] = striker.laws[object.preset];
    const law = { mass, stiffness, dissipation, exponent, restitution };
    if (by) law.mass = by.mass;
    if (radius) {
      const [k, mu, a] = this.map.presets[object.preset].touching[by.preset];
      Object.assign(law, { stiffness: k * Math.sqrt(radius), dissipation: mu, exponent: a, restitution: 0 });
    }
    if (surface) {
      if ("restitution" in given) refuse(`restitution = ${given.restitution}: expected dissipation, along a surface`);
      Object.assign(law, { dissipation: surface.dissipation, restitution: 0 });
    }
    if ("dissipation" in given && "restitution" in given) refuse("dissipation, restitution: expected one of the two");
    if ("dissipation" in given) law.restitution = 0;
    for (const key of Object.keys(law)) if (key in given) law[key] = given[key];
    return law;
  }

  /** Of a striker that falls: the velocity at which it meets the object, and when. */
  fall(motion, value) {
    const height = value("height");
    const thrown = value("velocity");
    const gravity = value("gravity");
    const velocity = Math.sqrt(thrown ** 2 + 2 * gravity * height);
    motion.velocity = velocity;
    motion.delay = thrown > 0 ? (2 * height) / (velocity + thrown) : (velocity - thrown) / gravity;
  }

  slip(motion, { given, defaults }, sliding, law, target) {
    const own = { ...sliding, force: law.mass * GRAVITY };
    for (const key of Object.keys(own)) motion[key] = given[key] ?? defaults[key] ?? own[key];
    if (motion.dynamic > motion.static) refuse(`dynamic = ${motion.dynamic}: expected at most static = ${motion.static}`);
    if ("press" in given) {
      if (!this.goesOn(given.press, `${target}/press`)) refuse(`press = ${given.press}: expected the id of a press on ${target} that goes on`);
      motion.press = this.running.get(given.press).number;
    }
  }

  goesOn(id, address) {
    return this.running.get(id)?.addresses.includes(address) ?? false;
  }

  /** The number of a gesture that begins. */
  start(id, address) {
    const known = this.running.get(id) ?? { number: ++this.number, addresses: [] };
    known.addresses.push(address);
    this.running.set(id, known);
    return known.number;
  }

  /** Strike a copy of an object that is tuned to a note; it is made when the note is first played. */
  note(verb, target, object, address, args, time) {
    const { given } = parsed(address, verb, args);
    if (given.velocity === 0) return undefined;
    const name = `${target}.${given.note}`;
    if (!(name in this.objects)) {
      if (!object.pitch) refuse("note: it has no audible mode, and so no pitch");
      this.copy({ ...object, tune: (A4_HZ * 2 ** ((given.note - A4) / 12)) / object.pitch, body: -1 }, name, {}, time);
    }
    const speed = SLOWEST * (FASTEST / SLOWEST) ** ((Math.max(given.velocity, 1) - 1) / 126);
    return this.perform(`/object/${name}/impact`, [speed, ...args.slice(2)], time);
  }

  /** Make an object, and its body, in another's image. */
  make({ name, like, size = 1, material, ...settings }, time) {
    const of = under(this.objects, like) ?? refuse(`${like}: no such object; there are ${Object.keys(this.objects).join(", ")}`);
    if (Object.hasOwn(this.objects, name)) refuse(`${name}: there is an object of that name`);
    if (this.bodies && Object.hasOwn(this.bodies.silent, name)) refuse(`${name}: there is a silent body of that name`);
    if (/[ #*,/?[\]{}]/.test(name)) refuse(`name = ${name}: expected no blank, and none of #*,/?[]{}`);
    const made = { ...of, tune: 0, change: [...(of.change ?? [0, 0, 0])], material: of.material };
    made.change[0] += Math.log2(size);
    if (Math.abs(made.change[0]) > 10) refuse(`size = ${size}: expected up to 1024 times the score's object`);
    const { materials, presets } = this.map;
    if (material !== undefined) {
      const own = under(materials, presets[of.preset].material) ?? refuse(`${like}: it has no material`);
      const [stiff, dense] = under(materials, material) ?? refuse(`${material}: no such material; expected one of ${Object.keys(materials).join(", ")}`);
      const denser = Math.log2(dense / own[1]);
      Object.assign(made, { material, change: [made.change[0], 0.5 * (Math.log2(stiff / own[0]) - denser), denser] });
    }
    this.copy(made, name, settings, time);
    const number = made.material === undefined ? -1 : Object.keys(materials).indexOf(made.material);
    if (of.body >= 0) this.objects[name].body = this.bodies.make(this.objects[name], [...made.change, number]);
  }

  /** Leave the place of an object that was made live to others, and its body. */
  leave({ slot, first, modes, body }, time) {
    const { scene, map } = this;
    if (modes) this.freed.push({ slot, first, modes, until: Math.max(time, scene.position) + 2 * map.quantum, sent: scene.whole(map.state.written) });
    if (body >= 0) this.bodies.free(body);
  }

  /** A place for an object of so many modes: one that was left, the tightest, or a new one. */
  place(modes) {
    const { state } = this.map;
    const { scene } = this;
    const isFree = ({ slot, until, sent }) => scene.position >= until && scene.whole(state.read) >= sent && !scene.whole(state.slots + slot * state.object + state.used);
    const [left] = this.freed.filter((each) => each.modes >= modes && isFree(each)).sort((a, b) => a.modes - b.modes);
    this.freed = this.freed.filter((each) => each !== left);
    if (left) return { slot: left.slot, first: left.first, modes: left.modes };
    if (this.mode + modes > state.modes || this.slot + 1 >= state.objects) refuse(`no capacity for another object: ${this.slot + 1} of ${state.objects}, ${this.mode} of ${state.modes} modes`);
    this.mode += modes;
    return { slot: ++this.slot, first: this.mode - modes, modes };
  }

  /** Make an object of another's modes, with settings; a plate's copies do not stretch. */
  copy(object, name, settings, time) {
    const { command, verbs, materials, presets } = this.map;
    const { scene } = this;
    if (!scene.live && object.batch >= scene.next) refuse(`${name}: its object is not there yet`);
    scene.expectRoom(1);
    const own = presets[object.preset].material;
    const made = { ...object, ...this.place(this.said(object.made, "layout.size")), serial: ++this.serial };
    made.settings = { ...object.settings, ...settings };
    const losses = (material) => under(materials, material)?.slice(2) ?? [0, 0, 0, 0];
    const bytes = scene.copied(object.made, made.first, [...(object.change ?? [0, 0, 0]), ...losses(own), ...losses(object.material ?? own)]);
    if (!bytes) {
      this.leave({ ...made, body: -1 }, NOW);
      refuse(`${name}: no object can be so`);
    }
    const changed = { time, number: 0, slot: made.slot, serial: made.serial };
    for (const [key, value] of Object.entries(made.settings)) {
      changed[`settings.${key}`] = inEngine(verbs[`/object/NAME/${key}`].required[0], value);
    }
    if (made.tune) changed["settings.tune"] = made.tune;
    this.write(new DataView(bytes.buffer), changed);
    scene.send(bytes);
    this.objects[name] = { ...made, body: -1 };
  }

  /** Send a command for each point, or none where there is no room for all. */
  change(command, all) {
    this.scene.expectRoom(all.length);
    for (const point of all) this.send({ ...command, ...point });
  }

  send(command) {
    const { command: { size }, kinds } = this.map;
    const view = new DataView(new ArrayBuffer(size));
    this.write(view, { "ramp.after": 0, ...command, channel: -1, kind: kinds[command.kind] });
    this.scene.send(new Uint8Array(view.buffer));
  }

  write(view, values) {
    for (const [name, value] of Object.entries(values)) {
      const [place, whole] = this.map.command.fields[name];
      if (whole) view.setBigInt64(place, BigInt(value), true);
      else view.setFloat64(place, value, true);
    }
  }
}
