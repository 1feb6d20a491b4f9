// What a hand does to an object, as messages: strikes, drops, rolls, slides, presses, meetings.

import { strokeOn } from "./strokes.js";

const SURFACES = { glass: "glass", polycarbonate: "glass", wood: "polished-wood", rosewood: "polished-wood", ceramic: "tile" };
const OTHERWISE = "steel";
const SMALLEST = 0.004; // m: a smaller body is caught in every groove

export const GRAVITY = 9.80665;

export class Hands extends EventTarget {
  constructor(link, scene) {
    super();
    this.link = link;
    this.scene = scene;
    this.striker = null; // null: each object's own
    this.chosen = { impact: {}, bounce: {}, roll: {}, press: {}, spin: {}, slide: {} };
    this.count = 0;
  }

  strikerOf(object) {
    return this.scene.strikers.get(this.striker ?? object.preset.striker);
  }

  /** An id that no other page uses. */
  id(kind) {
    return `${kind}-${this.link.client.slice(0, 6)}-${++this.count}`;
  }

  keys(gesture, object, more = {}) {
    const given = { ...this.chosen[gesture], ...more };
    delete given[{ impact: "velocity", bounce: "height", roll: "speed", press: "force", spin: "duration", slide: "speed" }[gesture]];
    if (this.striker && !("by" in given)) given.striker = this.striker;
    if ("restitution" in given) delete given[gesture === "roll" || gesture === "slide" ? "restitution" : "dissipation"];
    return Object.entries(given).flat();
  }

  velocity(object) {
    return this.chosen.impact.velocity ?? object.preset.velocity;
  }

  /** `stamp`: when a finger asked for it, ms of the page's clock. */
  strike(object, position, speed = this.velocity(object), stamp = undefined) {
    this.link.send(`/object/${object.name}/impact`, speed, position, ...this.keys("impact", object));
    this.tell("struck", { object, position, stamp });
  }

  drop(object, position, height = this.chosen.bounce.height ?? object.preset.gestures.bounce?.height ?? 0.2) {
    const id = this.id("ball");
    this.link.send(`/object/${object.name}/bounce`, height, position, ...this.keys("bounce", object, { id }));
    this.tell("dropped", { object, position, value: height, id });
  }

  spin(object, position) {
    const id = this.id("spin");
    const usual = object.preset.gestures.spin;
    const duration = this.chosen.spin.duration ?? usual?.duration ?? 3;
    this.link.send(`/object/${object.name}/spin`, duration, position, ...this.keys("spin", object, { id, ...(this.striker || usual ? {} : { striker: "coin" }) }));
  }

  /** What a drag over an object does; a striker that was chosen rolls. */
  stroke(object) {
    return this.striker ? { gesture: "roll", keys: {} } : strokeOn(object);
  }

  /** Begin the stroke of a drag. */
  draw(object, position, speed) {
    const { gesture, keys } = this.stroke(object);
    return this[gesture](object, position, speed, keys);
  }

  roll(object, position, speed, keys = {}) {
    const id = this.id("roll");
    const { radius, click_radius } = this.strikerOf(object);
    const surface = SURFACES[object.material] ?? OTHERWISE;
    const round = keys.surface ? {} : { radius: Math.max(SMALLEST, radius ?? click_radius ?? 0.008) };
    const more = { ...round, surface, ...keys, ...this.chosen.roll, id };
    this.link.send(`/object/${object.name}/roll`, speed, position, ...this.keys("roll", object, more));
    return id;
  }

  slide(object, position, speed = this.chosen.slide.speed ?? 0.1, keys = { striker: "bow", force: 2 }) {
    const id = this.id("slide");
    const more = { ...(this.striker ? {} : keys), ...this.chosen.slide, id };
    this.link.send(`/object/${object.name}/slide`, speed, position, ...this.keys("slide", object, more));
    return id;
  }

  press(object, position) {
    const id = this.id("hand");
    const force = this.chosen.press.force ?? 5;
    const more = this.striker ? { id } : { id, striker: "hand" };
    this.link.send(`/object/${object.name}/press`, force, position, ...this.keys("press", object, more));
    return id;
  }

  steer(id, key, value) {
    return this.link.steer(`/gesture/${id}/${key}`, value);
  }

  stop(id) {
    this.link.send(`/gesture/${id}/stop`);
  }

  meet(object, position, speed, other, otherPosition) {
    const more = { by: other.name, by_position: otherPosition };
    const chosen = this.chosen.impact;
    this.chosen.impact = {};
    const keys = this.keys("impact", object, more);
    this.chosen.impact = chosen;
    this.link.send(`/object/${object.name}/impact`, speed, position, ...keys);
  }

  note(object, note, velocity) {
    const striker = this.striker ? ["striker", this.striker] : [];
    this.link.send(`/object/${object.name}/note`, note, velocity, object.preset.position, ...striker);
  }

  /** Lay a hand on an object and on the copies of it that notes are played on, as firmly as 0 to 1 says. */
  damp(object, firmly) {
    object.settings.damp = firmly;
    for (const name of this.scene.namesOf(object)) this.link.steer(`/object/${name}/damp`, firmly);
  }

  tell(type, detail) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }
}
