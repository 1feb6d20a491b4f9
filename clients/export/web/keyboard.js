// A keyboard over MIDI: keys, the pedal, bends and pressure, as the notes of an object's copies; MPE as its players have it.

const [LOWER, UPPER] = [0, 15]; // channels that manage a zone of MPE
const [USUAL, MEMBERS] = [2, 48]; // semitones that a bend reaches
const [BEND_RANGE, ZONE, NONE] = [0, 6, 0x3fff]; // registered parameters
const [DATA, PEDAL, BRIGHTNESS, MSB, LSB, OTHER_LSB, OTHER_MSB, NOTES_OFF] = [6, 64, 74, 101, 100, 98, 99, 123];

export class Keyboard {
  /** send: is called with an address and its arguments. */
  constructor(send) {
    this.send = send;
    this.channels = Array.from({ length: 16 }, () => ({ bend: 0, range: USUAL, pressure: 0, pedal: null, manager: null, parameter: NONE, setUp: false }));
    this.forget();
  }

  /** Forget the notes that were played: their copies are gone. */
  forget() {
    this.notes = new Map(); // by the name of the copy: its channel, note, whether it is held, and what it was told
  }

  /** Carry out a message of MIDI that is of keys, the pedal, bends or pressure; name: of the object that plays. */
  hear(name, [status, first, second]) {
    const [kind, number] = [status & 0xf0, status & 0x0f];
    const channel = this.channels[number];
    if (kind === 0x90 && second > 0) return this.press(name, number, first, second);
    if (kind === 0x80 || kind === 0x90) this.release((each) => each.channel === number && each.note === first);
    else if (kind === 0xa0) for (const each of this.notes.values()) each.pressure = each.channel === number && each.note === first ? second / 127 : each.pressure;
    else if (kind === 0xb0) this.control(number, channel, first, second);
    else if (kind === 0xd0) Object.assign(channel, { pressure: first / 127, setUp: true });
    else if (kind === 0xe0) Object.assign(channel, { bend: ((second << 7) | first) / 8192 - 1, setUp: true });
    for (const copy of this.notes.keys()) this.settle(copy);
  }

  press(name, number, note, velocity) {
    this.lookForZone(number);
    const copy = `${name}.${note}`;
    const known = this.notes.get(copy);
    this.notes.set(copy, { channel: number, note, held: true, pressure: 0, told: known?.told ?? { tune: 0, damp: 0 } });
    if (known) this.settle(copy); // the dampers rise before the blow
    this.send(`/object/${name}/note`, note, velocity);
    if (!known) this.settle(copy);
  }

  release(isMeant) {
    for (const each of this.notes.values()) if (isMeant(each)) each.held = false;
  }

  control(number, channel, controller, value) {
    if (controller === PEDAL) channel.pedal = value / 127;
    if (controller === BRIGHTNESS) channel.setUp = true;
    if (controller === NOTES_OFF) this.release((each) => each.channel === number);
    if (controller === MSB) channel.parameter = (channel.parameter & 0x7f) | (value << 7);
    if (controller === LSB) channel.parameter = (channel.parameter & 0x3f80) | value;
    if (controller === OTHER_LSB || controller === OTHER_MSB) channel.parameter = NONE;
    if (controller !== DATA) return;
    if (channel.parameter === BEND_RANGE) {
      const zone = this.channels.filter((each) => each === channel || (channel.manager !== null && each.manager === channel.manager));
      for (const each of zone) each.range = value; // of a member it is that of all
      this.zoned = true;
    }
    if (channel.parameter === ZONE && (number === LOWER || number === UPPER)) this.zone(number, value);
  }

  /** Lay out a zone of MPE. */
  zone(manager, members) {
    this.zoned = true;
    for (let n = 1; n < 16; n++) {
      const each = this.channels[manager ? manager - n : n];
      if (n <= members) Object.assign(each, { manager, range: MEMBERS });
      else if (each.manager === manager) Object.assign(each, { manager: null, range: USUAL });
    }
  }

  /** A keyboard for MPE may not say so: it sets a channel up before each note, or plays two other than the first at once. */
  lookForZone(number) {
    const channel = this.channels[number];
    const others = [...this.notes.values()].some((each) => each.held && each.channel > LOWER && each.channel !== number);
    if (number > LOWER && !this.zoned && (channel.setUp || others)) this.zone(LOWER, 15);
    channel.setUp = false;
  }

  /** Tell a copy its bend, and the hand or the damper on it, where they change: before a pedal's first message there are no dampers. */
  settle(copy) {
    const each = this.notes.get(copy);
    const channel = this.channels[each.channel];
    const manager = channel.manager === null ? null : this.channels[channel.manager];
    const pedals = [channel.pedal, manager?.pedal].filter((place) => typeof place === "number");
    const damper = pedals.length ? 1 - Math.max(...pedals) : 0;
    const now = {
      tune: channel.range * channel.bend + (manager ? manager.range * manager.bend : 0),
      damp: each.held ? Math.max(each.pressure, channel.pressure) : damper,
    };
    for (const [name, value] of Object.entries(now)) if (value !== each.told[name]) this.send(`/object/${copy}/${name}`, value);
    each.told = now;
  }
}
