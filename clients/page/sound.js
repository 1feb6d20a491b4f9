// The sound in the browser: heard through an AudioWorklet, looked at as a spectrum, recorded as a WAV file.

import { wav } from "./wav.js";

const LOOKED_AT = 4096; // frames of a spectrum
const LEAD = 0.12; // s by which scheduled buffers go ahead, where there is no AudioWorklet

export class Sound {
  constructor(link) {
    this.link = link;
    this.context = null;
    this.node = null;
    this.isHeard = false;
    this.latest = new Float32Array(LOOKED_AT);
    this.rate = 48000;
    this.recording = null;
    this.state = { waits: 0, gaps: 0, playing: false };
    this.end = 0;
    link.on("/sound", (position, rate, channels, data) => this.take(position, rate, channels, data));
    link.addEventListener("open", () => link.command("SOUND", true));
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
        await resumed;
      }
    }
    if (this.context.state !== "running") await this.context.resume();
  }

  async stop() {
    this.isHeard = false;
    await this.context?.suspend();
  }

  /** Seconds from the engine's sample to the loudspeaker, but for the network. */
  get latency() {
    const device = this.context ? this.context.baseLatency + (this.context.outputLatency || 0) : 0;
    return this.isHeard ? device + (this.node ? this.state.waits : LEAD) : 0;
  }

  take(position, rate, channels, data) {
    this.rate = rate;
    const frames = data.byteLength / 4 / channels;
    const left = new Float32Array(frames);
    const right = new Float32Array(frames);
    for (let n = 0; n < frames; n++) {
      left[n] = data.getFloat32(4 * channels * n, true);
      right[n] = channels > 1 ? data.getFloat32(4 * (channels * n + 1), true) : left[n];
    }
    this.keep(left, right);
    if (this.recording) this.record(position, left, right);
    if (!this.isHeard || this.context?.state !== "running") return;
    if (this.node) this.node.port.postMessage({ position, rate, left, right });
    else if (!this.hasWorklet) this.schedule(rate, left, right);
  }

  /** Play a block by a buffer of its own: later than the worklet, but it needs no https. */
  schedule(rate, left, right) {
    const buffer = this.context.createBuffer(2, left.length, rate);
    buffer.copyToChannel(left, 0);
    buffer.copyToChannel(right, 1);
    const source = new AudioBufferSourceNode(this.context, { buffer });
    source.connect(this.context.destination);
    const now = this.context.currentTime;
    if (this.end < now + 0.01 || this.end > now + 0.5) this.end = now + LEAD;
    source.start(this.end);
    this.end += left.length / rate;
    this.state = { waits: this.end - now, gaps: 0, playing: true };
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
