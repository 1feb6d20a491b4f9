// What is drawn over the objects: contacts, strikers in flight, hands, rolls, nodal lines.

import { GRAVITY } from "./hands.js";
import { disc, look } from "./materials.js";

const FLASH = 520; // ms
const TAU = 2 * Math.PI;
const HEIGHT = 230; // px per sqrt(m): a flight of 1 m is drawn so high
const LOST = 900; // ms after which a striker that was to come back is forgotten

export class Marks {
  constructor(table) {
    this.table = table;
    this.flashes = [];
    this.balls = new Map();
    table.scene.link.on("/hit", (...args) => this.hit(...args));
    table.scene.link.on("/gesture/end", (id) => this.balls.delete(id));
  }

  get busy() {
    return this.flashes.length > 0 || this.balls.size > 0;
  }

  hit(name, id, sample, position, speed, impulse, seconds, velocity) {
    const object = this.table.scene.objects.get(name) ?? this.table.scene.objects.get(name.replace(/\.\d+(\.\d+)?$/, ""));
    if (!object) return;
    position = this.table.touch?.hands.points.get(id) ?? position;
    this.flashes.push({ object, position, speed, since: performance.now() });
    if (this.flashes.length > 60) this.flashes.shift();
    const ball = this.balls.get(id);
    // The striker's momentum says how fast it leaves, and so how high it comes and when it is back.
    if (ball) Object.assign(ball, { position, up: Math.max(0, impulse / ball.mass - velocity), since: performance.now(), falls: 0 });
  }

  /** Follow a striker that is dropped from a height. */
  follow({ object, position, value, id }, striker, gravity = GRAVITY) {
    this.balls.set(id, { object, position, gravity, striker, mass: striker.mass, radius: size(striker), falls: value, up: 0, since: performance.now() });
    this.table.wake();
  }

  draw(g) {
    this.nodes(g);
    const now = performance.now();
    this.flashes = this.flashes.filter((flash) => now - flash.since < FLASH);
    for (const flash of this.flashes) this.flash(g, flash, (now - flash.since) / FLASH);
    for (const [id, ball] of this.balls) if (!this.ball(g, ball, (now - ball.since) / 1000)) this.balls.delete(id);
    for (const pointer of this.table.touch?.pointers.values() ?? []) this.pointer(g, pointer);
  }

  color(name) {
    return getComputedStyle(document.documentElement).getPropertyValue(name);
  }

  selection(g, object, x, y) {
    const { w, h } = object.body;
    const s = this.table.scale;
    g.save();
    g.strokeStyle = this.color("--accent");
    g.globalAlpha = 0.55;
    g.lineWidth = 1.2;
    g.setLineDash([1, 5]);
    g.lineCap = "round";
    g.beginPath();
    g.roundRect(x - (w * s) / 2 - 13, y - (h * s) / 2 - 13, w * s + 26, h * s + 26, 16);
    g.stroke();
    g.restore();
  }

  flash(g, { object, position, speed }, age) {
    const [x, y] = this.table.pixel(object, position);
    const strong = Math.min(1, 0.25 + 0.3 * Math.log10(1 + 30 * speed));
    g.save();
    g.globalCompositeOperation = "lighter";
    g.globalAlpha = (1 - age) ** 2 * strong;
    g.fillStyle = "#fff4dc";
    g.beginPath();
    g.arc(x, y, 4 + 12 * strong * (1 - age), 0, TAU);
    g.fill();
    g.globalCompositeOperation = "source-over";
    g.strokeStyle = this.color("--flash");
    g.lineWidth = 2.5 * (1 - age);
    for (const far of [26, 52]) {
      g.beginPath();
      g.arc(x, y, 5 + far * strong * Math.sqrt(age) * this.table.scale, 0, TAU);
      g.stroke();
    }
    g.restore();
  }

  /** A striker in flight; false once it does not come back. */
  ball(g, ball, seconds) {
    const [x, y] = this.table.pixel(ball.object, ball.position);
    const height = ball.falls - 0.5 * ball.gravity * seconds ** 2 + ball.up * seconds;
    if (height < 0 && ball.up === 0 && ball.falls === 0) return seconds * 1000 < LOST;
    const over = Math.sqrt(Math.max(0, height)) * HEIGHT * this.table.scale;
    this.shadow(g, x, y, ball.radius, over);
    this.sphere(g, x, y - over - ball.radius, ball.radius, ball.striker);
    const gone = seconds - Math.max((2 * ball.up) / ball.gravity, Math.sqrt((2 * ball.falls) / ball.gravity));
    return gone * 1000 < LOST;
  }

  shadow(g, x, y, r, over) {
    g.save();
    g.fillStyle = `rgba(0,0,0,${0.45 / (1 + over / 90)})`;
    g.beginPath();
    g.ellipse(x, y, r * (1 + over / 240), r * 0.45 * (1 + over / 240), 0, 0, TAU);
    g.fill();
    g.restore();
  }

  sphere(g, x, y, r, { material }) {
    g.save();
    g.translate(x, y);
    g.fillStyle = disc(g, r, look(material));
    g.beginPath();
    g.arc(0, 0, r, 0, TAU);
    g.fill();
    g.restore();
  }

  pointer(g, pointer) {
    const { kind, object, position, x, y } = pointer;
    const { hands } = this.table.touch;
    if (kind === "roll") {
      const striker = hands.strikerOf(object);
      const r = size(striker);
      const [px, py] = this.table.pixel(object, position);
      this.shadow(g, x, y, r, 4);
      this.sphere(g, x, y - r * 0.6, r, striker);
      this.dot(g, px, py);
      this.label(g, x, y - 2 * r - 12, `${pointer.speed.toFixed(2)} m/s`);
    } else if (kind === "hold") {
      g.save();
      g.fillStyle = this.color("--accent");
      g.globalAlpha = 0.28;
      g.beginPath();
      g.arc(x, y, 30, 0, TAU);
      g.fill();
      g.restore();
      this.label(g, x, y - 44, "hand");
    } else if (kind === "pull" && pointer.back) this.sling(g, pointer);
    else if (kind === "carry") this.carried(g, pointer);
  }

  sling(g, { object, position, x, y, speed }) {
    const [px, py] = this.table.pixel(object, position);
    g.save();
    g.strokeStyle = this.color("--accent");
    g.lineWidth = 2;
    g.setLineDash([2, 6]);
    g.lineCap = "round";
    g.beginPath();
    g.moveTo(px, py);
    g.lineTo(x, y);
    g.stroke();
    g.restore();
    this.dot(g, px, py);
    this.sphere(g, x, y, 11, this.table.touch.hands.strikerOf(object));
    this.label(g, x, y - 26, `${speed.toFixed(speed < 1 ? 2 : 1)} m/s`);
  }

  carried(g, pointer) {
    const { over, x, y } = pointer;
    const { touch } = this.table;
    const striker = over ? touch.hands.strikerOf(over.object) : this.table.scene.strikers.get(touch.hands.striker ?? "steel");
    const r = size(striker);
    if (!over) {
      this.sphere(g, x, y - r, r, striker);
      return;
    }
    const height = touch.height(pointer);
    const lift = Math.sqrt(height) * HEIGHT * this.table.scale;
    const [px, py] = this.table.pixel(over.object, over.position);
    this.shadow(g, px, py, r, lift);
    this.sphere(g, px, py - lift - r, r, striker);
    this.label(g, px, py - lift - 2 * r - 12, `${(100 * height).toFixed(0)} cm`);
  }

  dot(g, x, y) {
    g.fillStyle = this.color("--accent");
    g.beginPath();
    g.arc(x, y, 3.5, 0, TAU);
    g.fill();
  }

  label(g, x, y, text) {
    g.save();
    g.font = "600 12px system-ui, sans-serif";
    const w = g.measureText(text).width + 14;
    g.fillStyle = this.color("--label");
    g.beginPath();
    g.roundRect(x - w / 2, y - 11, w, 21, 10);
    g.fill();
    g.fillStyle = this.color("--on-label");
    g.textAlign = "center";
    g.textBaseline = "middle";
    g.fillText(text, x, y);
    g.restore();
  }

  /** The nodal lines of the mode that is loudest where the mouse is. */
  nodes(g) {
    const touch = this.table.touch;
    const hover = touch && !touch.pointers.size ? touch.hover : null;
    const modes = hover?.object.modes;
    if (!modes || (modes.strike.length < 2 && !modes.shapes) || !this.table.scene.objects.has(hover.object.name)) return;
    const { body } = hover.object;
    const rows = modes.strike.length;
    const here = body.nodes ? modes.shapes[body.nearest(hover.position)] : modes.strike[Math.round(hover.position * (rows - 1))];
    // While it rings, the mode that does so the loudest; at rest the one of the most energy after an even blow.
    const rings = this.table.scene.glow(hover.object) > 0;
    const loud = (phi, i) =>
      rings ? ((hover.object.amps.get(i) ?? 0) * Math.abs(phi)) / (hover.object.peaks[i] || 1) : Math.abs(phi * modes.loud[i]) * Math.sqrt(modes.t60[i]);
    let best = 0;
    here.forEach((phi, i) => loud(phi, i) > loud(here[best], best) && (best = i));
    const s = this.table.scale;
    const [x, y] = this.table.middle(hover.object);
    g.save();
    g.translate(x, y);
    g.scale(s, s);
    g.strokeStyle = this.color("--node");
    g.lineWidth = 1.6;
    g.setLineDash([4, 4]);
    if (body.nodes) body.nodes(g, modes.shapes.map((row) => row[best]));
    for (let n = 1; n < rows && !body.nodes; n++) {
      const [a, b] = [modes.strike[n - 1][best], modes.strike[n][best]];
      if (a * b < 0) body.cross(g, (n - 1 + a / (a - b)) / (rows - 1));
    }
    g.restore();
    const [px, py] = this.table.pixel(hover.object, hover.position);
    this.dot(g, px, py);
    const hertz = modes.frequency[best];
    this.label(g, x, y - (body.h * s) / 2 - 20, hertz < 1000 ? `${hertz.toFixed(0)} Hz` : `${(hertz / 1000).toFixed(2)} kHz`);
  }
}

/** Pixels of a striker's radius. */
function size({ radius, click_radius, mass }) {
  const metres = radius ?? click_radius ?? 0.006 * Math.cbrt(mass / 0.003);
  return 7 + 110 * Math.min(0.16, metres) ** 0.75;
}
