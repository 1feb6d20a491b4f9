// An AudioWorklet that plays the server's sound from a jitter buffer, at the pace at which it comes.

const LENGTH = 1 << 16; // frames of the buffer
const TARGET = 0.06; // s that wait in it at first
const MORE = 0.02; // s that wait longer after each gap
const MOST = 0.14; // s that wait at most; what is this much above it is skipped

class Player extends AudioWorkletProcessor {
  constructor() {
    super();
    this.ring = [new Float32Array(LENGTH), new Float32Array(LENGTH)];
    this.written = 0;
    this.read = 0; // frames, with a fraction
    this.rate = sampleRate;
    this.playing = false;
    this.gaps = 0;
    this.target = this.mean = TARGET;
    this.told = 0;
    this.next = null;
    this.port.onmessage = ({ data }) => (data.from.onmessage = (message) => this.take(message.data));
  }

  take({ position, rate, left, right }) {
    this.rate = rate;
    if (this.next !== null && position > this.next) this.write(new Float32Array(Math.min(position - this.next, rate / 4)));
    this.next = position + left.length;
    this.write(left, right);
  }

  write(left, right = left) {
    for (let i = 0; i < left.length; i++) {
      const at = (this.written + i) % LENGTH;
      this.ring[0][at] = left[i];
      this.ring[1][at] = right[i];
    }
    this.written += left.length;
  }

  process(_, [output]) {
    const frames = output[0].length;
    const waits = (this.written - this.read) / this.rate;
    if (!this.playing && waits >= this.target) this.begin();
    if (waits > this.target + MOST) this.begin();
    if (this.playing) this.fill(output, frames, waits);
    this.tell(frames);
    return true;
  }

  begin() {
    this.read = this.written - this.target * this.rate;
    this.mean = this.target;
    this.playing = true;
  }

  fill(output, frames, waits) {
    // The two clocks differ by some parts in a hundred thousand: the pace follows the mean of what waits.
    this.mean += (waits - this.mean) * 0.002;
    const pace = (this.rate / sampleRate) * (1 + Math.max(-0.004, Math.min(0.004, 0.05 * (this.mean - this.target))));
    for (let i = 0; i < frames; i++) {
      if (this.read + 3 > this.written) {
        this.gaps++;
        this.target = Math.min(MOST, this.target + MORE);
        this.playing = false;
        return;
      }
      const at = Math.floor(this.read);
      const x = this.read - at;
      for (let c = 0; c < output.length; c++) {
        const ring = this.ring[Math.min(c, 1)];
        const y0 = ring[(at + LENGTH - 1) % LENGTH];
        const y1 = ring[at % LENGTH];
        const y2 = ring[(at + 1) % LENGTH];
        const y3 = ring[(at + 2) % LENGTH];
        const slope = 0.5 * (y2 - y0);
        const curve = y0 - 2.5 * y1 + 2 * y2 - 0.5 * y3;
        output[c][i] = y1 + x * (slope + x * (curve + x * (0.5 * (y3 - y0) + 1.5 * (y1 - y2))));
      }
      this.read += pace;
    }
  }

  tell(frames) {
    this.told += frames;
    if (this.told > sampleRate / 4) {
      this.told = 0;
      this.port.postMessage({ waits: this.mean, gaps: this.gaps, playing: this.playing });
    }
  }
}

registerProcessor("carom-player", Player);
