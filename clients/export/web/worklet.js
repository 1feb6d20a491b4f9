// The engine in a page's audio thread.

import { Scene } from "./scene.js";

const WARM = 100; // ms that the engine is warmed up for at most
const SAID_EVERY = 48000; // frames between two warnings
const LOST = ["dropped", "linear", "refused"]; // counts of a report that are said

class Carom extends AudioWorkletProcessor {
  constructor({ processorOptions: { module, map, data, tracker, live } }) {
    super();
    try {
      this.scene = new Scene(module, map, data, tracker);
      this.warmUp();
      this.scene.load(live);
    } catch (error) {
      this.scene = null; // what is no scene is refused, and silent
      this.port.postMessage({ stopped: error.message });
      return;
    }
    this.port.onmessage = ({ data }) => this.hear(data);
    this.port.postMessage({ ready: true, megabytes: this.scene.memory.buffer.byteLength / 1e6 });
  }

  /** Strike everything once: the browser compiles what that takes before it is heard. */
  warmUp() {
    const until = Date.now() + WARM;
    this.scene.load(true);
    for (const name of Object.keys(this.scene.messages.objects)) {
      try {
        this.scene.messages.perform(`/object/${name}/impact`, []);
      } catch {
        continue; // one that can't be struck is said when it is
      }
      for (let n = 0; n < 8 && Date.now() < until; n++) this.scene.compute(128);
    }
  }

  hear({ load, report, frame, address, args, at, ask }) {
    if (load !== undefined) return this.scene.load(load);
    const { bodies } = this.scene.messages;
    if (report) return this.port.postMessage({ ask, report: { load: this.load, ...this.scene.report, contacts: bodies?.contacts ?? null } });
    try {
      if (frame && !bodies) throw new Error("frame: expected a scene with bodies: /world/body in its score");
      if (frame) return this.port.postMessage({ ask, id: bodies.frame(frame, this.load ?? 0) });
      const time = at === undefined ? undefined : this.scene.sampleAt(at);
      const id = this.scene.messages.perform(address, args, time);
      if (ask) this.port.postMessage({ ask, id });
    } catch (error) {
      this.port.postMessage({ ask, refused: error.message });
    }
  }

  process(_inputs, [channels]) {
    const frames = channels[0].length;
    const { scene } = this;
    if (!scene) return false;
    const begun = Date.now();
    const width = scene.map.channels;
    for (let done = 0; done < frames; ) {
      const now = scene.compute(frames - done);
      for (let channel = 0; channel < channels.length; channel++) {
        const out = channels[channel];
        const from = Math.min(channel, width - 1);
        for (let n = 0; n < now; n++) out[done + n] = scene.sound[n * width + from];
      }
      done += now;
    }
    this.weigh(Date.now() - begun, frames);
    this.warn();
    return true;
  }

  /** The share of real time that computing takes, of late: of whole ms, which are right on average. */
  weigh(milliseconds, frames) {
    const share = Math.min(1, frames / this.scene.map.rate);
    this.load = (this.load ?? 0) * (1 - share) + (milliseconds / 1000 / (frames / this.scene.map.rate)) * share;
  }

  /** Say what was left out since this was said last, at most once in a second. */
  warn() {
    const { report } = this.scene;
    if (report.frames < (this.said?.frames ?? 0)) this.said = undefined; // it has begun anew
    const [dropped, linear, refused] = LOST.map((name) => report[name] - (this.said?.[name] ?? 0));
    if (dropped + linear + refused < 1 || report.frames < (this.said?.frames ?? -SAID_EVERY) + SAID_EVERY) return;
    this.said = report;
    const s = (count) => (count === 1 ? "" : "s");
    const told = [
      dropped && `left out ${dropped} contact${s(dropped)}, of at most ${report.loudest.toFixed(0)} LUFS: play fewer at once`,
      linear && `${linear} blow${s(linear)} did not make a plate swell: too many plates swell at once`,
      refused && `left out ${refused} command${s(refused)} of the score: the engine could not take them, or was full`,
    ];
    for (const warning of told) if (warning) this.port.postMessage({ warning });
  }
}

registerProcessor("carom", Carom);
