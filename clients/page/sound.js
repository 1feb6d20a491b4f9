// The sound in the browser: heard through an AudioWorklet, looked at as a spectrum, recorded as a WAV file.

import { wav } from "./wav.js";

const LOOKED_AT = 4096; // frames of a spectrum
const LEAD = 0.12; // s by which scheduled buffers go ahead, where there is no AudioWorklet

export class Sound {
  constructor(link) {
    this.context = null;
    this.node = null;
    this.isHeard = false;
    this.latest = new Float32Array(LOOKED_AT);
    this.rate = 48000;
    this.recording = null;
    this.state = { waits: 0, gaps: 0, playing: false };
    this.end = 0;
    this.ear = new Worker("/page/ear.js", { type: "module" });
    this.ear.onmessage = ({ data: { position, rate, left, right } }) => this.take(position, rate, left, right);
    link.addEventListener("open", () => this.ear.postMessage({ address: link.address }), { once: true });
  }

  /** Whether this browser has what low latency needs: it does on https and on localhost only. */
  get hasWorklet() {
    return typeof AudioWorkletNode !== "undefined" && isSecureContext;
  }

  /** Begin to be heard; call it from a click. */
  async start() {
    this.isHeard = true;
    if (!this.context) {
      this.context = new AudioContext({ latencyHint: "interactive", sampleRate: this.rate });
      if (this.hasWorklet) {
        const resumed = this.context.resume();
        await this.context.audioWorklet.addModule("/page/player.js");
        this.node = new AudioWorkletNode(this.context, "carom-player", { numberOfInputs: 0, outputChannelCount: [2] });
        this.node.port.onmessage = ({ data }) => (this.state = data);
        this.node.connect(this.context.destination);
        const { port1, port2 } = new MessageChannel();
        this.node.port.postMessage({ from: port1 }, [port1]);
        this.ear.postMessage({ player: port2 }, [port2]);
        await resumed;
      }
    }
    if (this.context.state !== "running") await this.context.resume();
  }

  async stop() {
    this.isHeard = false;
    await this.context?.suspend();
  }

  /** Seconds that the device itself takes, as the browser knows it. */
  get device() {
    return this.context?.outputLatency || 0;
  }

  /** When a sample of the engine is heard, in ms of the page's clock, less the device's own latency; null if unknown. */
  heardAt(sample) {
    const { contextTime, performanceTime } = this.context.getOutputTimestamp();
    if (this.state.at === undefined || !performanceTime) return null;
    const at = this.state.at + (sample - this.state.sample) / this.rate;
    return performanceTime + 1000 * (at - contextTime - this.device);
  }

  take(position, rate, left, right) {
    this.rate = rate;
    this.keep(left, right);
    if (this.recording) this.record(position, left, right);
    if (this.isHeard && !this.hasWorklet && this.context?.state === "running") this.schedule(position, rate, left, right);
  }

  /** Play a block by a buffer of its own: later than the worklet, but it needs no https. */
  schedule(position, rate, left, right) {
    const buffer = this.context.createBuffer(2, left.length, rate);
    buffer.copyToChannel(left, 0);
    buffer.copyToChannel(right, 1);
    const source = new AudioBufferSourceNode(this.context, { buffer });
    source.connect(this.context.destination);
    const now = this.context.currentTime;
    if (this.end < now + 0.01 || this.end > now + 0.5) this.end = now + LEAD;
    source.start(this.end);
    this.state = { waits: this.end - now, gaps: 0, playing: true, at: this.end, sample: position };
    this.end += left.length / rate;
  }

  keep(left, right) {
    const size = this.latest.length;
    const count = Math.min(left.length, size);
    this.latest.copyWithin(0, count);
    for (let n = 0; n < count; n++) {
      this.latest[size - count + n] = 0.5 * (left[left.length - count + n] + right[right.length - count + n]);
    }
  }

  startRecording() {
    this.recording = { first: null, next: 0, blocks: [], lost: 0 };
  }

  record(position, left, right) {
    const kept = this.recording;
    if (kept.first === null) kept.first = kept.next = position;
    if (position > kept.next) {
      const gap = new Float32Array(position - kept.next);
      kept.lost += gap.length;
      kept.blocks.push([gap, gap]);
    }
    kept.blocks.push([left, right]);
    kept.next = position + left.length;
  }

  /** The recording as a WAV file, with its first sample and how many samples are missing in it. */
  stopRecording() {
    const { first, blocks, lost } = this.recording;
    this.recording = null;
    return { first: first ?? 0, lost, file: wav(blocks, this.rate) };
  }
}
