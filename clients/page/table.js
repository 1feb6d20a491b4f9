// The table: where things are drawn, and what lies under a pointer.

import { draw } from "./frames.js";
import { Marks } from "./marks.js";

const SEGMENTS = 28;

export class Table {
  constructor(main, scene) {
    this.main = main;
    this.scene = scene;
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
    scene.addEventListener("known", () => this.wake());
    for (const address of ["/modes", "/hit", "/touch"]) scene.link.on(address, () => this.wake());
  }

  fit() {
    const { clientWidth, clientHeight } = this.main;
    const dense = Math.min(window.devicePixelRatio || 1, 3);
    for (const each of [this.bodies, this.stage]) Object.assign(each, { width: clientWidth * dense, height: clientHeight * dense });
    this.w = clientWidth;
    this.h = clientHeight;
    this.dense = dense;
    this.scale = Math.max(0.42, Math.min(2.6, Math.min(this.w / 760, this.h / 560, Math.sqrt(this.w * this.h) / 650)));
    this.pictures.clear();
    this.laid = "";
    this.arrange();
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
  metresPerPixel({ preset: { geometry }, body }) {
    const metres = geometry.length ?? 2 * (geometry.radius ?? 0.1);
    return metres / (body.w * this.scale);
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
    const spots = objects.map(({ name, preset, x, y }) => [name, preset.name, x, y]);
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
    const key = object.preset.name;
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
