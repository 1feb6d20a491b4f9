// What a hand does to an object, as messages: strikes, drops, rolls, slides, presses, meetings.

import { scaleOf } from "./dom.js";
import { strokeOn } from "./strokes.js";

const SURFACES = { glass: "glass", polycarbonate: "glass", wood: "polished-wood", rosewood: "polished-wood", ceramic: "tile" };
const OTHERWISE = "steel";
const USUAL = { bounce: 0.2, roll: 0.5, press: 5, spin: 3, slide: 0.1 };
const KEPT = 256; // gestures whose points are known
const SMALLEST = 0.004; // m: a smaller body is caught in every groove

export const GRAVITY = 9.80665;

export class Hands extends EventTarget {
  constructor(link, scene) {
    super();
    this.link = link;
    this.scene = scene;
    this.striker = null; // null: each object's own
    this.swarm = null; // null: a touch strikes; else the gesture that it begins
    this.gestures = scene.catalogue.gestures;
    this.chosen = Object.fromEntries(Object.keys(this.gestures).map((name) => [name, {}]));
    this.count = 0;
    this.points = new Map(); // by gesture, the point of a surface where it touches
  }

  strikerOf(object) {
    return this.scene.strikers.get(this.striker ?? object.preset.striker);
  }

  /** An id that no other page uses. */
  id(kind) {
    return `${kind}-${this.link.client.slice(0, 6)}-${++this.count}`;
  }

  /** A place on an object as arguments: a position, or a point of its surface, which is kept for the marks. */
  placed(place, id) {
    if (!Array.isArray(place)) return [place];
    this.points.set(id, place);
    if (this.points.size > KEPT) this.points.delete(this.points.keys().next().value);
    return ["point", ...place];
  }

  keys(gesture, object, more = {}) {
    const given = { ...this.chosen[gesture], ...more };
    if (this.gestures[gesture].what?.length) {
      delete given.what;
      delete given.restitution;
      return Object.entries(given).flat();
    }
    delete given[this.gestures[gesture].argument.name];
    given.play = 1; // whatever strikes what is heard
    if (this.striker && !("by" in given)) given.striker = this.striker;
    if ("restitution" in given) delete given[this.gestures[gesture].along ? "restitution" : "dissipation"];
    return Object.entries(given).flat();
  }

  /** The argument of a gesture where none is chosen: the preset's own, else one that suits most objects. */
  usual(object, name) {
    const { argument } = this.gestures[name];
    if (name === "impact") return object.preset.velocity;
    return object.preset.gestures[name]?.[argument.name] ?? USUAL[name] ?? scaleOf(argument).value(0.5);
  }

  /** The argument of a gesture as it is chosen. */
  argument(object, name) {
    return this.chosen[name][this.gestures[name].argument.name] ?? this.usual(object, name);
  }

  velocity(object) {
    return this.argument(object, "impact");
  }

  /** Begin any gesture as it is chosen; its id, if it can be stopped. */
  play(object, name, position) {
    const own = { impact: "strike", bounce: "drop" }[name] ?? name;
    return own in this ? this[own](object, position) : this.begin(object, name, position);
  }

  begin(object, name, position, value = this.argument(object, name), more = {}) {
    const id = this.id(name);
    const { what } = this.gestures[name];
    const first = what?.length ? this.chosen[name].what ?? what[0] : value;
    this.link.send(`/object/${object.name}/${name}`, first, ...this.placed(position, id), ...this.keys(name, object, { ...more, id }));
    const { falls, argument } = this.gestures[name];
    if (falls && argument.name === "height") this.tell("dropped", { object, position, value, id, gesture: name });
    return id;
  }

  /** `stamp`: when a finger asked for it, ms of the page's clock. */
  strike(object, position, speed = this.velocity(object), stamp = undefined) {
    const own = Array.isArray(position) ? { id: this.id("impact") } : {};
    this.link.send(`/object/${object.name}/impact`, speed, ...this.placed(position, own.id), ...this.keys("impact", object, own));
    this.tell("struck", { object, position, stamp, ...own });
  }

  drop(object, position, height = this.argument(object, "bounce")) {
    return this.begin(object, "bounce", position, height);
  }

  /** Begin the chosen swarm; its id, if it ends as the finger is lifted. */
  scatter(object, position) {
    const { treads, breaks } = this.gestures[this.swarm];
    const id = this.begin(object, this.swarm, position);
    if (breaks) object.settings.damp = 1; // it lies in pieces
    return treads || breaks ? null : id;
  }

  spin(object, position) {
    const isGiven = this.striker || object.preset.gestures.spin;
    return this.begin(object, "spin", position, undefined, isGiven ? {} : { striker: "coin" });
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
    const { radius, click_radius } = this.strikerOf(object);
    const surface = SURFACES[object.material] ?? OTHERWISE;
    const round = keys.surface ? {} : { radius: Math.max(SMALLEST, radius ?? click_radius ?? 0.008) };
    return this.begin(object, "roll", position, speed, { ...round, surface, ...keys, ...this.chosen.roll });
  }

  slide(object, position, speed, keys = object.preset.gestures.slide ? {} : { striker: "bow", force: 2 }) {
    const more = { ...(this.striker ? {} : keys), ...this.chosen.slide };
    return this.begin(object, "slide", position, speed, more);
  }

  press(object, position) {
    return this.begin(object, "press", position, undefined, this.striker ? {} : { striker: "hand" });
  }

  steer(id, key, value) {
    return this.link.steer(`/gesture/${id}/${key}`, value);
  }

  /** Steer a gesture to a place on its object. */
  lead(id, place) {
    if (!Array.isArray(place)) return this.steer(id, "position", place);
    this.points.set(id, place);
    return this.link.steer(`/gesture/${id}/point`, ...place);
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
    this.link.send(`/object/${object.name}/impact`, speed, ...this.placed(position), ...keys);
  }

  note(object, note, velocity) {
    const striker = this.striker ? ["striker", this.striker] : [];
    this.link.send(`/object/${object.name}/note`, note, velocity, object.preset.position, ...striker, "play", 1);
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
