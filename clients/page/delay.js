// From the finger to the sound: how long it took for the blows of late, measured.
//
// A blow is found again among the contacts that the server tells, by object and position, or by its id. The player says which of the
// engine's samples is heard when, by the context's clock, and the context when that is, by the page's.

const FORGETS = 2000; // ms after which a blow is taken as lost
const KEPT = 9; // blows, of which the median is shown

export class Delay {
  constructor(link, hands, sound) {
    this.sound = sound;
    this.awaited = []; // blows that were sent: name, position, and the time of their event
    this.measured = []; // ms, the latest last
    hands.addEventListener("struck", ({ detail: { object, position, stamp, id } }) => {
      if (stamp === undefined || !sound.isHeard || !sound.state.playing) return;
      this.awaited = this.awaited.filter((each) => performance.now() - each.stamp < FORGETS);
      this.awaited.push({ name: object.name, position, stamp, id });
    });
    link.on("/hit", (name, id, sample, position) => this.hit(name, id, sample, position));
  }

  hit(name, id, sample, position) {
    const found = this.awaited.findIndex((each) => each.name === name && (each.id ? each.id === id : Math.abs(each.position - position) < 1e-6));
    if (found < 0) return;
    const [{ stamp }] = this.awaited.splice(found, 1);
    const heard = this.sound.heardAt(sample);
    if (heard !== null) this.measured = [...this.measured.slice(1 - KEPT), heard - stamp];
  }

  /** ms from a finger's event to its sound, less the device's own latency: the median of late; null before any. */
  get median() {
    if (!this.measured.length) return null;
    return this.measured.toSorted((a, b) => a - b)[this.measured.length >> 1];
  }
}
