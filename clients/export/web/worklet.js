// The engine in a page's audio thread.

import { Scene } from "./scene.js";

const WARM = 100; // ms that the engine is warmed up for at most
const SAID_EVERY = 48000; // frames between two warnings

class Carom extends AudioWorkletProcessor {
  constructor({ processorOptions: { module, map, data, live } }) {
    super();
    try {
      this.scene = new Scene(module, map, data);
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

  hear({ load, address, args, at, ask }) {
    if (load !== undefined) return this.scene.load(load);
    try {
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
    this.warn();
    return true;
  }

  /** Say how many commands of the score the engine has not taken since this was said last. */
  warn() {
    const { computed, refused } = this.scene;
    if (computed < (this.said?.computed ?? 0)) this.said = undefined; // it has begun anew
    const count = refused - (this.said?.refused ?? 0);
    if (count < 1 || computed < (this.said?.computed ?? -SAID_EVERY) + SAID_EVERY) return;
    this.said = { computed, refused };
    this.port.postMessage({ warning: `${count} commands of the score were left out: the engine could not take them, or was full` });
  }
}

registerProcessor("carom", Carom);
