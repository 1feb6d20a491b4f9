// The table: where things are drawn, and what lies under a pointer.

import { draw } from "./frames.js";
import { Marks } from "./marks.js";
import { EDGE } from "./scene.js";

const SEGMENTS = 28;
const APART = 8; // px between objects
const TOP = 34; // px that are left free for words
const NAME = 36, LETTER = 2.9; // px that an object's name takes below it, and a letter of it to both sides
const STEP = 11; // px between places that are tried
const SPOTS = [[0.5, 0.48], [0.2, 0.26], [0.81, 0.24], [0.18, 0.78], [0.81, 0.76], [0.5, 0.87]]; // of the first objects
const CLOSER = 0.93; // times as large is all drawn, where there is no room
const CROWDED = 0.5, CLOSEST = 0.3;
const SIZE = "carom-size"; // where it is kept how large that is

const meet = (a, b) => a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];
const apart = ([x, y], [u, v]) => Math.hypot(x - u, y - v);

/** The item of the least value; null of none. */
function least(items, value) {
  let [found, low] = [null, Infinity];
  for (const item of items) {
    const at = value(item);
    if (at < low) [found, low] = [item, at];
  }
  return found;
}

/** How far each of some points swings now, as a share of the farthest. */
function swingOf(shapes, amps, peaks) {
  const swing = shapes.map((row) => Math.hypot(...[...amps].map(([i, amp]) => (amp * (row[i] ?? 0)) / (peaks[i] || 1))));
  const most = Math.max(...swing) || 1;
  return swing.map((each) => each / most);
}

export class Table extends EventTarget {
  constructor(main, scene) {
    super();
    this.main = main;
    this.scene = scene;
    scene.room = this;
    this.size = Number(localStorage.getItem(SIZE) ?? 1);
    this.bodies = main.querySelector("#bodies");
    this.stage = main.querySelector("#stage");
    this.pills = main.querySelector("#pills");
    this.g = this.stage.getContext("2d");
    this.pictures = new Map();
    this.laid = "";
    this.marks = new Marks(this);
    this.touch = null;
    this.frame = () => this.draw();
    new ResizeObserver(() => this.fit()).observe(main);
    scene.addEventListener("changed", () => this.arrange());
    scene.addEventListener("selected", () => this.arrange());
    scene.addEventListener("known", () => this.arrange());
    for (const address of ["/modes", "/hit", "/touch"]) scene.link.on(address, () => this.wake());
  }

  fit() {
    const { clientWidth, clientHeight } = this.main;
    const dense = Math.min(window.devicePixelRatio || 1, 3);
    for (const each of [this.bodies, this.stage]) Object.assign(each, { width: clientWidth * dense, height: clientHeight * dense });
    this.w = clientWidth;
    this.h = clientHeight;
    this.dense = dense;
    this.draws(this.size);
    this.dispatchEvent(new Event("fitted"));
  }

  /** Draw all so many times as large as there is room for. */
  draws(size) {
    this.size = size;
    localStorage.setItem(SIZE, size);
    this.scale = size * Math.max(0.42, Math.min(2.6, this.w / 760, this.h / 560, Math.sqrt(this.w * this.h) / 650));
    this.pictures.clear();
    this.laid = "";
    this.arrange();
  }

  /** Draw all as large as on a fresh table. */
  spread() {
    this.draws(1);
  }

  /** What an object of a body takes of the table, with its name, about a place: [left, top, right, bottom] in px. */
  box(name, { w, h }, [x, y]) {
    const half = Math.max((w * this.scale) / 2, LETTER * name.length + 12) + APART / 2;
    return [x - half, y - (h * this.scale) / 2 - APART / 2, x + half, y + (h * this.scale) / 2 + NAME];
  }

  /** A place near another one (shares of the sides) where an object lies on no other; all get smaller if need be. */
  freeSpot(name, body, near) {
    const wished = (near ? [near] : SPOTS).map(([x, y]) => [x * this.w, y * this.h]);
    const cost = near ? (spot) => apart(spot, wished[0]) : ([x, y]) => Math.min(x, this.w - x) + 0.1 * Math.abs(y - this.h / 2);
    let found = null;
    while (!found && this.size > CLOSEST) {
      const named = (name) => (this.size > CROWDED ? name : ""); // where all is small, names may lie on each other
      const about = (spot) => this.box(named(name), body, spot);
      const taken = [...this.scene.objects.values()].map((each) => this.box(named(each.name), each.body, this.middle(each)));
      const isFree = (spot) => this.isInside(about(spot)) && !taken.some((each) => meet(each, about(spot)));
      found = wished.find(isFree) ?? least(this.places(isFree), cost);
      if (!found) this.draws(this.size * CLOSER);
    }
    return (found ?? this.loneliest(name, body)).map((each, n) => each / [this.w, this.h][n]);
  }

  isInside([left, top, right, bottom]) {
    return left >= 0 && top >= TOP && right <= this.w && bottom <= this.h;
  }

  /** Pixels all over the table that are accepted. */
  places(accepts) {
    const spots = [];
    const [left, top, right, bottom] = [EDGE * this.w, EDGE * this.h, (1 - EDGE) * this.w, (1 - EDGE) * this.h];
    for (let y = top; y < bottom; y += STEP) for (let x = left; x < right; x += STEP) spots.push([x, y]);
    return spots.filter(accepts);
  }

  /** The pixel that is farthest from the middles of all objects. */
  loneliest(name, body) {
    const middles = [...this.scene.objects.values()].map((each) => this.middle(each));
    const places = this.places((spot) => this.isInside(this.box(name, body, spot)));
    return least(places.length ? places : [[this.w / 2, this.h / 2]], (spot) => -Math.min(...middles.map((each) => apart(spot, each))));
  }

  spot(event) {
    const box = this.stage.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  middle(object) {
    return [object.x * this.w, object.y * this.h];
  }

  /** A place on the table, as shares of its sides, that lies some pixels from another one. */
  share([x, y], dx, dy) {
    return [x + dx / this.w, y + dy / this.h];
  }

  local(object, x, y) {
    const [mx, my] = this.middle(object);
    return [(x - mx) / this.scale, (y - my) / this.scale];
  }

  /** Where on its strike path an object is under a pixel; null beside it. */
  positionOn(object, x, y) {
    return object.body.at(...this.local(object, x, y));
  }

  distanceFrom(object, x, y) {
    const [lx, ly] = this.local(object, x, y);
    const { w, h } = object.body;
    return this.scale * Math.hypot(Math.max(0, Math.abs(lx) - w / 2), Math.max(0, Math.abs(ly) - h / 2));
  }

  /** The pixel of a point of an object's strike path. */
  pixel(object, position) {
    const [x, y] = object.body.point(position);
    const [mx, my] = this.middle(object);
    return [mx + this.scale * x, my + this.scale * y];
  }

  /** Metres of an object per pixel on the table. */
  metresPerPixel({ body }) {
    return body.metres / (body.w * this.scale);
  }

  /** The object under a pixel, the nearest to whose middle it is, and the position on it. */
  find(x, y) {
    let found = null;
    for (const object of this.scene.objects.values()) {
      const position = this.positionOn(object, x, y);
      const far = Math.hypot(...this.local(object, x, y));
      if (position !== null && (!found || far < found.far)) found = { object, position, far };
    }
    return found;
  }

  /** Put the names of the objects where they belong. */
  arrange() {
    const left = new Map([...this.pills.children].map((pill) => [pill.dataset.name, pill]));
    for (const object of this.scene.objects.values()) {
      const pill = left.get(object.name) ?? this.pill(object);
      left.delete(object.name);
      const [x, y] = this.middle(object);
      const below = Math.min(this.h - 30, y + (this.scale * object.body.h) / 2 + 9);
      pill.style.transform = `translate(-50%) translate(${Math.max(46, Math.min(this.w - 46, x))}px, ${below}px)`;
      pill.setAttribute("aria-pressed", String(object.name === this.scene.selected));
    }
    for (const pill of left.values()) pill.remove();
    this.wake();
  }

  pill(object) {
    const pill = document.createElement("button");
    pill.className = "pill";
    pill.dataset.name = object.name;
    pill.textContent = object.name.replaceAll("-", " ");
    pill.setAttribute("aria-label", `${object.name.replaceAll("-", " ")}: ${object.preset.description}. Enter strikes.`);
    pill.addEventListener("pointerdown", (event) => event.button === 0 && this.touch.grab(event, object, pill));
    pill.addEventListener("focus", () => this.scene.choose(object.name));
    this.pills.append(pill);
    return pill;
  }

  /** Turn an object about so many radians, if one can see it from all sides. */
  turn(object, about, above) {
    const { body } = object;
    if (!body.turned) return;
    this.pictures.delete(body.key);
    object.body = body.turned(about, above);
    this.arrange();
  }

  wake() {
    draw(this.frame);
  }

  draw() {
    const { g } = this;
    if (!this.w) return;
    this.lay();
    this.clear(g);
    let busy = this.marks.busy;
    for (const object of this.scene.objects.values()) {
      const glow = this.scene.glow(object);
      busy ||= glow > 0;
      if (glow > 0) this.drawRinging(object, glow);
    }
    this.marks.draw(g);
    this.touch?.rest();
    if (busy || this.touch?.pointers.size) this.wake();
  }

  clear(g) {
    g.setTransform(this.dense, 0, 0, this.dense, 0, 0);
    g.clearRect(0, 0, this.w, this.h);
  }

  /** Draw the objects as they are at rest, on a canvas below, if they are others or elsewhere than before. */
  lay() {
    const objects = [...this.scene.objects.values()];
    const { theme } = document.documentElement.dataset;
    const spots = objects.map(({ name, body, x, y }) => [name, body.key, x, y]);
    const laid = JSON.stringify([theme, this.scene.selected, spots]);
    if (laid === this.laid) return;
    this.laid = laid;
    const g = this.bodies.getContext("2d");
    this.clear(g);
    for (const object of objects) {
      if (object.name === this.scene.selected) this.marks.selection(g, object, ...this.middle(object));
      this.drawPicture(g, object);
    }
  }

  drawPicture(g, object) {
    const [x, y] = this.middle(object);
    const { image, w, h } = this.picture(object);
    g.drawImage(image, x - w / 2, y - h / 2, w, h);
  }

  drawRinging(object, glow) {
    const { g, scale } = this;
    const [x, y] = this.middle(object);
    const style = getComputedStyle(document.documentElement);
    g.save();
    g.globalAlpha = 0.55 * glow;
    const r = (Math.hypot(object.body.w, object.body.h) / 2) * scale * (1.15 + 0.25 * glow);
    const halo = g.createRadialGradient(x, y, r * 0.25, x, y, r);
    halo.addColorStop(0, style.getPropertyValue("--glow"));
    halo.addColorStop(1, "transparent");
    g.fillStyle = halo;
    g.fillRect(x - r, y - r, 2 * r, 2 * r);
    g.restore();
    this.drawPicture(g, object);
    if (!object.modes) return;
    g.save();
    g.translate(x, y);
    g.scale(scale, scale);
    g.globalCompositeOperation = "lighter";
    this.drawModes(object, glow);
    g.restore();
  }

  /** How far each part of an object swings now, as light: the sum of its loud modes' shapes. */
  drawModes(object, glow) {
    const { modes, body, amps, peaks } = object;
    if (body.shine) {
      body.shine(this.g, swingOf(modes.shapes, amps, peaks), glow);
      return;
    }
    const rows = modes.strike.length;
    const count = rows > 1 ? SEGMENTS : 1;
    const swing = new Float64Array(count);
    for (let n = 0; n < count; n++) {
      const row = modes.strike[Math.round(((n + 0.5) / count) * (rows - 1))];
      for (const [i, amp] of amps) if (i < row.length) swing[n] += ((amp * row[i]) / (peaks[i] || 1)) ** 2;
    }
    const most = Math.sqrt(Math.max(...swing)) || 1;
    for (let n = 0; n < count; n++) {
      const share = Math.sqrt(swing[n]) / most;
      body.glow(this.g, n / count, 1 / count, `rgba(255,176,72,${(0.62 * glow * share * share).toFixed(3)})`);
    }
  }

  /** An object's picture, drawn once for each size of the table. */
  picture(object) {
    const { key } = object.body;
    let picture = this.pictures.get(key);
    if (!picture) {
      const w = (object.body.w + 90) * this.scale;
      const h = (object.body.h + 90) * this.scale;
      const image = document.createElement("canvas");
      Object.assign(image, { width: Math.ceil(w * this.dense), height: Math.ceil(h * this.dense) });
      const g = image.getContext("2d");
      g.scale(this.dense * this.scale, this.dense * this.scale);
      g.translate(w / this.scale / 2, h / this.scale / 2);
      object.body.draw(g);
      this.pictures.set(key, (picture = { image, w, h }));
    }
    return picture;
  }
}
