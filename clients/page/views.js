// What one looks at: meters, numbers, the spectrum beside the modes, the force of the last contact.

import { short } from "./dom.js";
import { draw } from "./frames.js";

const LOWEST = 20, HIGHEST = 20000; // Hz
const SOFT = -110; // dB
const EVERY = 50; // ms
const RANGE = 60; // dB below full scale that the meter covers
const QUIETEST = -70; // LUFS that are told

function fitted(canvas) {
  const dense = Math.min(window.devicePixelRatio || 1, 2);
  const { clientWidth: w, clientHeight: h } = canvas;
  if (canvas.width !== Math.round(w * dense) || canvas.height !== Math.round(h * dense)) {
    Object.assign(canvas, { width: Math.round(w * dense), height: Math.round(h * dense) });
  }
  const g = canvas.getContext("2d");
  g.setTransform(dense, 0, 0, dense, 0, 0);
  g.clearRect(0, 0, w, h);
  return { g, w, h };
}

const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(name);

/** Power in dB of each bin of a windowed piece of sound: a radix-2 FFT. */
export function spectrum(sound) {
  const n = sound.length;
  const re = new Float64Array(n), im = new Float64Array(n);
  for (let i = 0, j = 0; i < n; i++) {
    re[j] = sound[i] * (0.5 - 0.5 * Math.cos((2 * Math.PI * i) / n));
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j |= bit;
  }
  for (let size = 2; size <= n; size *= 2) {
    const angle = (-2 * Math.PI) / size;
    for (let k = 0; k < size / 2; k++) {
      const [c, s] = [Math.cos(angle * k), Math.sin(angle * k)];
      for (let i = k; i < n; i += size) {
        const j = i + size / 2;
        const [a, b] = [re[j] * c - im[j] * s, re[j] * s + im[j] * c];
        re[j] = re[i] - a; im[j] = im[i] - b;
        re[i] += a; im[i] += b;
      }
    }
  }
  return Float64Array.from({ length: n / 2 }, (_, i) => 10 * Math.log10((re[i] ** 2 + im[i] ** 2) * (16 / n / n) + 1e-14));
}

export class Views {
  constructor(scene, sound, delay) {
    Object.assign(this, { scene, sound, delay, peaks: [-200, -200], limited: 0, limits: 0, words: "", last: null });
    this.smooth = null;
    const { link } = scene;
    link.on("/meter", (...args) => this.meter(...args));
    link.on("/force", (name, seconds, ...force) => (this.last = { name, seconds, force }));
    this.frame = () => this.draw();
    setInterval(() => document.hidden || draw(this.frame), EVERY);
  }

  draw() {
    this.spectrum();
    this.levels();
    if (this.last) this.force(this.last);
    this.last = null;
  }

  /** Levels: peaks come last, one for each channel, after the loudness (LUFS) and the limiter's gain (dB), if told. */
  meter(sample, load, quality, limited, contacts, ...levels) {
    const peaks = levels.splice(-this.scene.catalogue.channels);
    [this.loudness, this.gain] = levels;

    this.limits = limited > this.limited ? 12 : Math.max(0, this.limits - 1);
    this.limited = limited;
    this.peaks = peaks.map((peak, n) => Math.max(peak, (this.peaks[n] ?? -200) - 1.2));
    const words = [`load ${Math.round(100 * load)} %`];
    if (quality) words.push(`quality ${quality}`);
    if (this.loudness > QUIETEST) words.push(`${this.loudness.toFixed(0)} LUFS`);
    if (this.limits) words.push(this.gain === undefined ? "limiter" : `limiter ${this.gain.toFixed(1)} dB`);
    const { median } = this.delay;
    if (this.sound.isHeard && median !== null) {
      words.push(`delay ${Math.round(median)} + ${Math.round(1000 * this.sound.device)} ms`);
    }
    this.words = words.join(" · ");
  }

  levels() {
    const { g, w, h } = fitted(document.getElementById("meter"));
    this.peaks.slice(0, 2).forEach((peak, n) => {
      const share = Math.max(0, Math.min(1, 1 + peak / RANGE));
      g.fillStyle = color("--track");
      g.fillRect(0, n * (h / 2) + 1, w, h / 2 - 2);
      const shade = g.createLinearGradient(0, 0, w, 0);
      shade.addColorStop(0, color("--accent"));
      shade.addColorStop(0.8, color("--warm"));
      shade.addColorStop(1, "#ff5340");
      g.fillStyle = shade;
      g.fillRect(0, n * (h / 2) + 1, w * share, h / 2 - 2);
    });
    if (this.loudness > -RANGE) {
      g.fillStyle = color("--text");
      g.fillRect(w * (1 + this.loudness / RANGE) - 1, 0, 2, h);
    }
    if (this.limits && this.gain < 0) {
      g.fillStyle = "#ff5340"; // from the right: how far the limiter turned down
      g.fillRect(w * (1 + this.gain / RANGE), h - 3, (w * -this.gain) / RANGE, 3);
    }
    const numbers = document.getElementById("numbers");
    if (numbers.textContent !== this.words) numbers.textContent = this.words;
  }

  spectrum() {
    const canvas = document.getElementById("spectrum");
    if (!canvas.clientHeight) return;
    const { g, w, h } = fitted(canvas);
    const across = (hertz) => (w * Math.log(hertz / LOWEST)) / Math.log(HIGHEST / LOWEST);
    const up = (level) => h - 14 - (h - 18) * Math.max(0, Math.min(1, (level - SOFT) / -SOFT));
    this.grid(g, w, h, across);
    this.modes(g, h, across, up);
    const levels = spectrum(this.sound.latest);
    this.smooth = this.smooth?.map((old, i) => Math.max(levels[i], old - 2)) ?? levels;
    g.beginPath();
    g.moveTo(0, h - 14);
    const step = this.sound.rate / this.sound.latest.length;
    for (let x = 0; x <= w; x += 1.5) {
      const from = (LOWEST * (HIGHEST / LOWEST) ** (x / w)) / step;
      const to = (LOWEST * (HIGHEST / LOWEST) ** ((x + 1.5) / w)) / step;
      g.lineTo(x, up(this.between(from, to)));
    }
    g.lineTo(w, h - 14);
    const shade = g.createLinearGradient(0, 0, 0, h);
    shade.addColorStop(0, color("--warm"));
    shade.addColorStop(1, color("--fade"));
    g.fillStyle = shade;
    g.fill();
  }

  /** The highest level between two places among the bins; between two bins, what lies between theirs. */
  between(from, to) {
    const last = this.smooth.length - 1;
    if (to - from < 1) {
      const i = Math.min(last - 1, Math.floor(from));
      return this.smooth[i] + (from - i) * (this.smooth[i + 1] - this.smooth[i]);
    }
    let level = SOFT;
    for (let i = Math.floor(from); i <= Math.min(last, to); i++) level = Math.max(level, this.smooth[i]);
    return level;
  }

  grid(g, w, h, across) {
    g.fillStyle = color("--quiet");
    g.strokeStyle = color("--track");
    g.font = "10px system-ui, sans-serif";
    for (const [hertz, name] of [[50, "50"], [100, "100"], [200, "200"], [500, "500"], [1000, "1k"], [2000, "2k"], [5000, "5k"], [10000, "10k"]]) {
      const x = Math.round(across(hertz)) + 0.5;
      g.beginPath();
      g.moveTo(x, 4);
      g.lineTo(x, h - 14);
      g.stroke();
      g.fillText(name, x - 8, h - 3);
    }
  }

  /** The modes of the selected object: a line each, as high as they ring now. */
  modes(g, h, across, up) {
    const object = this.scene.objects.get(this.scene.selected);
    const note = document.getElementById("spectrum-note");
    const words = object ? `and the modes of ${object.name.replaceAll("-", " ")}` : "";
    if (note.textContent !== words) note.textContent = words;
    if (!object?.modes) return;
    const rings = this.scene.glow(object) > 0;
    g.strokeStyle = color("--node");
    object.modes.frequency.forEach((hertz, i) => {
      const amp = rings ? object.amps.get(i) : 0;
      g.globalAlpha = amp ? 1 : 0.4;
      g.beginPath();
      g.moveTo(across(hertz), h - 14);
      g.lineTo(across(hertz), amp ? up(20 * Math.log10(amp)) : h - 20);
      g.stroke();
    });
    g.globalAlpha = 1;
  }

  force({ name, seconds, force }) {
    const canvas = document.getElementById("force");
    if (!canvas.clientHeight) return;
    const { g, w, h } = fitted(canvas);
    const most = Math.max(...force, 1e-9);
    const values = [0, ...force, 0];
    const across = (i) => 8 + ((w - 16) * i) / (values.length - 1);
    g.beginPath();
    g.moveTo(across(0), h - 16);
    values.forEach((value, i) => g.lineTo(across(i), h - 16 - (h - 30) * Math.max(0, value / most)));
    g.strokeStyle = color("--accent");
    g.lineWidth = 1.8;
    g.lineJoin = "round";
    g.stroke();
    g.globalAlpha = 0.16;
    g.fillStyle = color("--accent");
    g.fill();
    g.globalAlpha = 1;
    const strong = most >= 1000 ? `${(most / 1000).toFixed(1)} kN` : `${short(most)} N`;
    const long = `${short(1000 * seconds)} ms`;
    document.getElementById("force-note").textContent = `on ${name.replaceAll("-", " ")}: ${strong}, ${long}`;
    canvas.setAttribute("aria-label", `Force of the last contact, on ${name}: up to ${strong}, for ${long}`);
  }
}
