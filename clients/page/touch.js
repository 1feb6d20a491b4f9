// Fingers, pens and mice on the table: each pointer goes its own way from pressing to letting go.

import { speedOf } from "./strokes.js";

const MOVED = 11; // px before a touch is a drag
const OFF = 26; // px beside an object, from which on a drag pulls the striker back
const SECOND = 2; // button of a mouse
const HOLD = 380; // ms until a touch is a hold
const SLOWEST = 0.01, FASTEST = 5; // m/s of a stroke; the first where it rests under the finger
const FORGETS = 90; // ms after which a pointer that does not move has no speed
const SMOOTH = 0.04; // s over which a pointer's speed is taken
const TURNED = 0.01; // rad per px
const PULLED = 260; // px for the hardest strike
const LOWEST = 0.03, HIGHEST = 1.2, RISE = 1100; // m, m, ms: how a striker that is carried rises

export class Touch {
  constructor(stage, table, hands) {
    this.table = table;
    this.hands = hands;
    this.pointers = new Map();
    this.mode = "play"; // what a drag does: play, move or turn
    this.holdAfter = HOLD;
    stage.addEventListener("pointerdown", (event) => this.down(event, stage));
    stage.addEventListener("pointermove", (event) => this.move(event));
    stage.addEventListener("pointerup", (event) => this.up(event));
    stage.addEventListener("pointercancel", (event) => this.leave(event.pointerId));
    stage.addEventListener("pointerleave", () => (this.hover = null));
    stage.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  /** The speed that a pointer asks for: its pressure's where it has one, else the chosen one. */
  speed(event, object) {
    const usual = this.hands.velocity(object);
    const feels = event.pointerType === "pen" || (event.pointerType === "touch" && ![0, 0.5, 1].includes(event.pressure));
    if (feels && event.pressure > 0) return 0.05 * 100 ** event.pressure;
    return usual * (event.shiftKey ? 2.5 : event.altKey ? 0.3 : 1);
  }

  down(event, stage) {
    if (event.button > 0 && event.button !== SECOND) return;
    event.preventDefault();
    stage.setPointerCapture(event.pointerId);
    const [x, y] = this.table.spot(event);
    const found = this.table.find(x, y);
    const pointer = { x, y, x0: x, y0: y, vx: 0, vy: 0, at: event.timeStamp, ...found };
    this.pointers.set(event.pointerId, pointer);
    if ((event.button === SECOND || this.mode === "turn") && found?.object.body.turned) {
      pointer.kind = "turn";
      this.hands.scene.choose(found.object.name);
    } else if (event.button === SECOND) pointer.kind = "none";
    else if (!found) Object.assign(pointer, { kind: "carry", since: 0, over: null });
    else if (this.mode === "move") this.lift(pointer);
    else if (this.hands.swarm) {
      pointer.kind = "swarm";
      pointer.id = this.hands.scatter(found.object, found.position);
      this.hands.scene.choose(found.object.name);
    } else {
      pointer.kind = "touch";
      this.hands.strike(found.object, found.position, this.speed(event, found.object), event.timeStamp);
      this.hands.scene.choose(found.object.name);
      pointer.timer = setTimeout(() => this.hold(pointer), this.holdAfter);
    }
    this.table.wake();
  }

  lift(pointer, object = pointer.object) {
    Object.assign(pointer, { kind: "lift", object, from: [object.x, object.y], touched: new Set() });
    this.hands.scene.choose(object.name);
  }

  /** Begin to move an object by its name. */
  grab(event, object, pill) {
    const [x, y] = this.table.spot(event);
    const pointer = { x, y, x0: x, y0: y, vx: 0, vy: 0, at: event.timeStamp };
    this.lift(pointer, object);
    this.pointers.set(event.pointerId, pointer);
    pill.setPointerCapture(event.pointerId);
    pill.onpointermove = (each) => this.move(each);
    pill.onpointerup = (each) => this.up(each);
    pill.onpointercancel = (each) => this.leave(each.pointerId);
  }

  hold(pointer) {
    if (pointer.kind !== "touch") return;
    pointer.kind = "hold";
    pointer.id = this.hands.press(pointer.object, pointer.position);
    this.table.wake();
  }

  move(event) {
    const [x, y] = this.table.spot(event);
    const pointer = this.pointers.get(event.pointerId);
    if (!pointer) {
      this.hover = event.pointerType === "touch" ? null : this.table.find(x, y);
      this.table.wake();
      return;
    }
    const at = event.timeStamp; // of the finger, however late its event is heard
    const dt = Math.max(at - pointer.at, 1) / 1000;
    const share = 1 - Math.exp(-dt / SMOOTH);
    pointer.vx += ((x - pointer.x) / dt - pointer.vx) * share;
    pointer.vy += ((y - pointer.y) / dt - pointer.vy) * share;
    const moved = [x - pointer.x, y - pointer.y];
    Object.assign(pointer, { x, y, at });
    this[`go_${pointer.kind}`]?.(pointer, ...moved);
    this.table.wake();
  }

  go_touch(pointer) {
    if (Math.hypot(pointer.x - pointer.x0, pointer.y - pointer.y0) < MOVED) return;
    clearTimeout(pointer.timer);
    pointer.kind = "roll";
    this.go_roll(pointer);
  }

  go_turn({ object }, dx, dy) {
    this.table.turn(object, -TURNED * dx, TURNED * dy);
  }

  go_swarm(pointer) {
    if (pointer.id) this.go_hold(pointer);
  }

  go_hold(pointer) {
    const position = this.table.positionOn(pointer.object, pointer.x, pointer.y);
    if (position !== null) this.hands.lead(pointer.id, (pointer.position = position));
  }

  go_roll(pointer) {
    const { object } = pointer;
    const position = this.table.positionOn(object, pointer.x, pointer.y);
    if (position === null) {
      if (this.table.distanceFrom(object, pointer.x, pointer.y) > OFF) {
        this.end(pointer);
        pointer.kind = "pull";
      }
      return;
    }
    const pixels = Math.hypot(pointer.vx, pointer.vy);
    const wanted = speedOf(this.hands.stroke(object), pixels * this.table.metresPerPixel(object), pixels);
    const speed = Math.max(SLOWEST, Math.min(FASTEST, wanted));
    Object.assign(pointer, { position, speed });
    if (!pointer.id) pointer.id = this.hands.draw(object, position, speed);
    else {
      this.hands.steer(pointer.id, "speed", speed);
      this.hands.lead(pointer.id, position);
    }
  }

  go_pull(pointer) {
    pointer.back = this.table.positionOn(pointer.object, pointer.x, pointer.y) === null;
    const far = Math.hypot(pointer.x - pointer.x0, pointer.y - pointer.y0);
    pointer.speed = 0.05 * 100 ** Math.min(1, far / PULLED);
  }

  go_carry(pointer) {
    const over = this.table.find(pointer.x, pointer.y);
    if (over?.object !== pointer.over?.object) pointer.since = performance.now();
    pointer.over = over;
  }

  go_lift(pointer) {
    const { object } = pointer;
    const scene = this.hands.scene;
    scene.place(object.name, ...this.table.share(pointer.from, pointer.x - pointer.x0, pointer.y - pointer.y0));
    this.table.arrange();
    for (const other of scene.objects.values()) {
      if (other === object) continue;
      const position = this.table.positionOn(other, ...this.table.middle(object));
      if (position === null) pointer.touched.delete(other.name);
      else if (!pointer.touched.has(other.name)) {
        pointer.touched.add(other.name);
        const speed = Math.max(0.05, Math.min(3, Math.hypot(pointer.vx, pointer.vy) / 500));
        this.hands.meet(other, position, speed, object, object.preset.position);
      }
    }
  }

  /** A pointer that rests has no speed: a roll under it comes to a crawl. */
  rest() {
    const now = performance.now();
    for (const pointer of this.pointers.values()) {
      if (pointer.kind === "roll" && pointer.id && now - pointer.at > FORGETS && pointer.speed > SLOWEST) {
        pointer.speed = SLOWEST;
        pointer.vx = pointer.vy = 0;
        this.hands.steer(pointer.id, "speed", SLOWEST);
      }
    }
  }

  height({ since }) {
    const share = Math.min(1, (performance.now() - since) / RISE);
    return LOWEST * (HIGHEST / LOWEST) ** share;
  }

  up(event) {
    const pointer = this.pointers.get(event.pointerId);
    if (!pointer) return;
    if (pointer.kind === "pull" && pointer.back) this.hands.strike(pointer.object, pointer.position, pointer.speed);
    if (pointer.kind === "carry" && pointer.over) {
      this.hands.drop(pointer.over.object, pointer.over.position, this.height(pointer));
      this.hands.scene.choose(pointer.over.object.name);
    }
    if (pointer.kind === "lift") this.put(pointer);
    this.leave(event.pointerId);
  }

  /** Put an object down: one that lies on another goes back to where it was. */
  put({ object, from, touched, x, y, x0, y0 }) {
    const scene = this.hands.scene;
    if (touched.size) scene.place(object.name, ...from);
    if (touched.size || Math.hypot(x - x0, y - y0) < 3) scene.moved(object.name);
    else scene.moved(object.name, from);
  }

  end(pointer) {
    clearTimeout(pointer.timer);
    if (pointer.id) this.hands.stop(pointer.id);
    pointer.id = null;
  }

  leave(id) {
    const pointer = this.pointers.get(id);
    if (pointer) this.end(pointer);
    this.pointers.delete(id);
    this.table.wake();
  }
}
