// An AudioWorklet that plays the server's sound from a jitter buffer, which is as short as the sound's ways allow.
//
// How much waits in the buffer falls with each of the browser's calls and rises with each block that comes. Its lowest
// value says how much later blocks might come without a gap. It is kept at a reserve: what is above is skipped where
// it is silent, else played a little faster; a gap makes the reserve longer, and calm makes it shorter again.

const LENGTH = 1 << 16; // frames of the buffer
const FIRST = 0.025; // s above the reserve that wait as it begins
const LEAST = 0.004, MORE = 0.006, MOST = 0.08; // s: the reserve at first, how much longer a gap makes it, at most
const CALM = 0.0002; // s by which it is shorter after a second without a gap
const FAR = 0.03; // s of lowest value above the reserve at which sound is skipped: blocks were held up
const NEAR = 0.005; // s of it likewise just after a gap
const LOOK = 0.25, LOOKS = 6; // s of a look at the lowest value, and how many count
const TOLERANCE = 0.001; // s about the reserve in which the pace is even
const GAIN = 0.2; // 1/s: pace against what is above the reserve
const FASTEST = 0.003; // of the pace: 5 cents
const SILENT = 1e-4; // -80 dB of full scale
const FADE = 256; // frames over which sound begins, or goes over what is skipped
const DECAY = 0.96; // of what is left at a gap, in a frame

class Player extends AudioWorkletProcessor {
  constructor() {
    super();
    this.ring = [new Float32Array(LENGTH), new Float32Array(LENGTH)];
    this.written = 0;
    this.read = 0; // frames, with a fraction
    this.offset = 0; // from a place in the ring to the engine's sample
    this.next = null; // the engine's sample that is due to come
    this.rate = sampleRate;
    this.playing = false;
    this.gaps = 0;
    this.reserve = LEAST;
    this.pace = 1;
    this.tail = [0, 0]; // what was heard last
    this.forget();
    this.port.onmessage = ({ data }) => (data.from.onmessage = (message) => this.take(message.data));
  }

  forget() {
    this.low = Infinity; // of this look
    this.lows = [];
    this.looked = 0; // frames
  }

  take({ position, rate, left, right }) {
    this.rate = rate;
    if (this.next !== null && position > this.next) this.write(new Float32Array(Math.min(position - this.next, rate / 4)));
    this.write(left, right);
    this.next = position + left.length;
    this.offset = this.next - this.written;
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
    if (!this.playing && this.written - this.read >= (FIRST + this.reserve) * this.rate) this.begin();
    const filled = this.playing ? this.fill(output, frames) : 0;
    output.forEach((channel, c) => {
      for (let i = filled; i < frames; i++) channel[i] = this.tail[c] *= DECAY;
      this.tail[c] = channel[frames - 1];
    });
    if (this.playing && filled < frames) this.gap(frames);
    else if (this.playing) this.look(frames);
    return true;
  }

  begin() {
    this.read = this.written - Math.round((FIRST + this.reserve) * this.rate);
    this.playing = true;
    this.fresh = 0; // frames since then, or since the latest skip
    this.skipped = 0; // frames
    this.pace = 1;
    this.forget();
  }

  /** Play what is there; returns how many frames. */
  fill(output, frames) {
    const step = (this.rate / sampleRate) * this.pace;
    const whole = step === 1 && Number.isInteger(this.read);
    for (let i = 0; i < frames; i++) {
      if (this.read + 3 > this.written) return i;
      const at = Math.floor(this.read);
      const share = Math.min(1, this.fresh++ / FADE);
      for (let c = 0; c < output.length; c++) {
        const ring = this.ring[Math.min(c, 1)];
        output[c][i] = whole ? ring[at % LENGTH] : between(ring, at, this.read - at);
        if (share < 1) output[c][i] = share * output[c][i] + (1 - share) * (this.skipped && ring[(at - this.skipped) % LENGTH]);
      }
      this.read += step;
    }
    return frames;
  }

  gap(frames) {
    this.gaps++;
    this.reserve = Math.min(MOST, this.reserve + MORE);
    this.playing = false;
    this.tell(frames);
  }

  /** Note how much waits now that the browser took its share, and set the pace by the lowest of late. */
  look(frames) {
    this.low = Math.min(this.low, (this.written - this.read) / this.rate);
    this.looked += frames;
    if (this.looked < LOOK * sampleRate) return;
    this.lows = [...this.lows.slice(1 - LOOKS), this.low];
    this.low = Infinity;
    this.looked = 0;
    this.reserve = Math.max(LEAST, this.reserve - CALM * LOOK);
    let spare = Math.min(...this.lows) - this.reserve;
    if (spare > (this.lows.length > 1 ? FAR : NEAR) || (spare > TOLERANCE && this.isSilent(spare))) {
      this.skipped = Math.round(this.read + spare * this.rate) - this.read;
      this.read += this.skipped;
      this.fresh = 0;
      this.lows = this.lows.map((low) => low - this.skipped / this.rate);
      spare = 0;
    }
    this.pace = Math.abs(spare) < TOLERANCE ? 1 : 1 + Math.max(-FASTEST, Math.min(FASTEST, GAIN * spare));
    this.tell(frames);
  }

  isSilent(seconds) {
    for (let at = Math.floor(this.read), end = at + seconds * this.rate + 2; at < end; at++) {
      if (Math.abs(this.ring[0][at % LENGTH]) > SILENT || Math.abs(this.ring[1][at % LENGTH]) > SILENT) return false;
    }
    return true;
  }

  /** `sample`: of the engine's, the one that is heard at the context's time `at`. */
  tell(frames) {
    const { gaps, playing, reserve } = this;
    const waits = (this.written - this.read) / this.rate;
    const at = (currentFrame + frames) / sampleRate;
    this.port.postMessage({ waits, gaps, playing, reserve, at, sample: this.read + this.offset });
  }
}

/** The cubic through four neighbours, between the two in the middle. */
function between(ring, at, x) {
  const y0 = ring[(at + LENGTH - 1) % LENGTH];
  const y1 = ring[at % LENGTH];
  const y2 = ring[(at + 1) % LENGTH];
  const y3 = ring[(at + 2) % LENGTH];
  return y1 + x * (0.5 * (y2 - y0) + x * (y0 - 2.5 * y1 + 2 * y2 - 0.5 * y3 + x * (0.5 * (y3 - y0) + 1.5 * (y1 - y2))));
}

registerProcessor("carom-player", Player);
