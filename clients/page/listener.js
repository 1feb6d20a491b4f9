// The listener on the table: objects are heard from where they lie, with the time and the level of their way.

const KEPT = "carom-listener"; // where it stood last, and whether it listens
const METRES = 3; // m that the table is wide
const GLIDE = 0.05; // s that a move takes, so that it is heard as one
const BEGIN = [0.5, 0.93]; // shares of the table's sides
const LEAST = 0.03; // of a side, between the listener and the table's edge
const STEP = 0.02; // of a side, for an arrow key
const ARROWS = { ArrowLeft: [-STEP, 0], ArrowRight: [STEP, 0], ArrowUp: [0, -STEP], ArrowDown: [0, STEP] };

export class Listener {
  /** `button` lets the listener in; `head` is its picture on the table, which is dragged. */
  constructor(button, head, scene, table) {
    Object.assign(this, { button, head, scene, table, told: new Map() });
    const { x, y, on } = JSON.parse(localStorage.getItem(KEPT) ?? "{}");
    [this.x, this.y] = [x ?? BEGIN[0], y ?? BEGIN[1]];
    button.onclick = () => this.listens(!this.on);
    head.onpointerdown = (event) => this.grab(event);
    head.onkeydown = (event) => this.step(event);
    scene.listener = this;
    scene.addEventListener("placed", ({ detail }) => this.tell(detail));
    scene.addEventListener("changed", () => this.tellAll());
    scene.link.addEventListener("open", () => this.again());
    table.addEventListener("fitted", () => this.again());
    this.listens(on ?? false);
  }

  /** Let it listen, or hear each object by its pan again. */
  listens(on) {
    if (this.on && !on) for (const name of this.told.keys()) this.scene.link.send(`/object/${name}/place`);
    this.on = on;
    this.button.setAttribute("aria-pressed", String(on));
    this.head.hidden = !on;
    this.again();
    this.keep();
  }

  /** Be as a table has it. */
  be({ x = this.x, y = this.y, on }) {
    [this.x, this.y] = [x, y];
    this.listens(on);
  }

  /** Put it somewhere: shares of the table's sides. */
  move(x, y) {
    [this.x, this.y] = [x, y].map((each) => Number(Math.min(1 - LEAST, Math.max(LEAST, each)).toFixed(4)));
    this.show();
    this.scene.link.steer("/listener", ...this.metres(this.x, this.y), "over", GLIDE);
    this.keep();
  }

  /** Tell all from the beginning: the server or the table's size may have changed. */
  again() {
    this.told.clear();
    if (!this.on) return;
    this.show();
    this.scene.link.send("/listener", ...this.metres(this.x, this.y), "layout", "pan");
    this.tellAll();
  }

  tellAll() {
    for (const name of this.told.keys()) if (!this.names.includes(name)) this.told.delete(name);
    for (const name of this.scene.objects.keys()) this.tell(name);
  }

  get names() {
    return [...this.scene.objects.values()].flatMap((object) => this.scene.namesOf(object));
  }

  /** Tell where an object, with the copies of it that notes are played on, lies. */
  tell(name) {
    const object = this.scene.objects.get(name);
    if (!this.on || !this.scene.isKnown || !object) return; // a server that was started anew has no object yet
    const place = this.metres(object.x, object.y);
    for (const each of this.scene.namesOf(object)) {
      const before = this.told.get(each);
      if (before === String(place)) continue;
      this.told.set(each, String(place));
      this.scene.link.send(`/object/${each}/place`, ...place, ...(before ? ["over", GLIDE] : []));
    }
  }

  /** A place (m) of shares of the table's sides: the listener looks up the table, along x, with y to the left. */
  metres(x, y) {
    const { w, h } = this.table;
    return [METRES * (0.5 - y) * (h / w), METRES * (0.5 - x), 0].map((each) => Number(each.toFixed(4)));
  }

  /** The lines of a score that have it listen: none where it doesn't. */
  get lines() {
    if (!this.on) return [];
    const places = [...this.scene.objects.values()].map(({ name, x, y }) => ["0.0", `/object/${name}/place`, ...this.metres(x, y)].join(" "));
    return [`# listener at ${this.x} ${this.y}`, ["0.0", "/listener", ...this.metres(this.x, this.y), "layout pan"].join(" "), ...places];
  }

  show() {
    const { w, h } = this.table;
    this.head.style.transform = `translate(-50%, -50%) translate(${this.x * w}px, ${this.y * h}px)`;
  }

  keep() {
    localStorage.setItem(KEPT, JSON.stringify({ x: this.x, y: this.y, on: this.on }));
    this.scene.dispatchEvent(new Event("set"));
  }

  grab(event) {
    if (event.button > 0) return;
    event.preventDefault();
    this.head.focus();
    this.head.setPointerCapture(event.pointerId);
    this.head.onpointermove = (each) => {
      const [x, y] = this.table.spot(each);
      this.move(x / this.table.w, y / this.table.h);
    };
    this.head.onpointerup = this.head.onpointercancel = () => (this.head.onpointermove = null);
  }

  step(event) {
    const by = ARROWS[event.key];
    if (!by) return;
    event.preventDefault();
    event.stopPropagation();
    this.move(this.x + by[0], this.y + by[1]);
  }
}
