// The controls of the selected object and of what strikes it, from the schema that the server checks messages by.

import { el, slider } from "./dom.js";

const VERBS = { impact: "strike", bounce: "drop" };
const LAW = ["mass", "stiffness", "dissipation", "exponent", "restitution"];
const HIDDEN = new Set([...LAW, "position", "gain", "seed", "by_radius"]);
const LASTS = 1500; // ms of a gesture that its button begins, where only a stop ends it

function capitalized(text) {
  return text[0].toUpperCase() + text.slice(1);
}

export class Controls {
  constructor(box, scene, hands) {
    Object.assign(this, { box, scene, hands, open: new Set() });
    for (const type of ["selected", "known"]) {
      scene.addEventListener(type, ({ detail }) => (type === "selected" || detail === scene.selected) && this.show());
    }
  }

  show() {
    const object = this.scene.objects.get(this.scene.selected);
    if (!object) {
      this.box.replaceChildren(el("p", { className: "quiet", textContent: "Add an object to play on." }));
      return;
    }
    this.box.replaceChildren(
      this.head(object),
      this.macros(object),
      this.section("object", "Object", this.settings(object)),
      ...Object.entries(this.scene.catalogue.gestures).map(([name, gesture]) => this.section(name, name, this.gesture(object, name, gesture))),
      this.section("law", "Contact law", this.law()),
      this.section("all", "Everything", [this.main()]),
    );
  }

  head(object) {
    const { name, preset, material, modes } = object;
    const facts = [material.replaceAll("-", " "), modes && `${modes.frequency.length}${modes.frequency.length === 64 ? "+" : ""} modes`,
      modes && `${modes.mass < 1 ? `${(modes.mass * 1000).toFixed(0)} g` : `${modes.mass.toFixed(1)} kg`}`].filter(Boolean).join(" · ");
    const copy = el("button", { textContent: "Copy" });
    copy.onclick = () => this.scene.add(preset.name);
    const remove = el("button", { textContent: "Remove" });
    remove.onclick = () => this.scene.remove(name);
    return el("div", { className: "head" },
      el("h2", { textContent: name.replaceAll("-", " ") }),
      el("p", { textContent: preset.description }),
      el("p", { className: "quiet", textContent: facts }),
      el("div", { className: "row" }, copy, remove));
  }

  /** The knobs that every object has, and a die that turns them. */
  macros(object) {
    const rows = this.scene.catalogue.macros.map((parameter) => {
      const { name, ends, help } = parameter;
      let first = true;
      const turn = (value) => {
        this.scene.turn(object.name, name, value, first);
        first = false;
      };
      const row = slider({ ...parameter, help: `${capitalized(help)}: ${ends.join(" to ")}` }, object.macros[name] ?? null, parameter.default, turn, () => {
        this.scene.turn(object.name, name, parameter.default);
        this.show();
      });
      row.querySelector("output").replaceWith(el("small", { textContent: ends.join(" – ") }));
      row.addEventListener("change", () => {
        first = true;
        this.scene.look(object, false);
      });
      return row;
    });
    const dice = el("button", { textContent: "Die", title: "Set all knobs at random; Undo restores them" });
    dice.onclick = () => this.scene.throwDice(object);
    const middle = el("button", { textContent: "Middle", title: "Set all knobs to the middle" });
    middle.onclick = () => this.scene.turnAll(object.name, Object.fromEntries(this.scene.catalogue.macros.map((each) => [each.name, each.default])));
    return el("div", { className: "macros", role: "group", "aria-label": "Macros" }, ...rows, el("div", { className: "row" }, dice, middle));
  }

  section(key, title, children) {
    const made = el("details", { open: this.open.has(key) }, el("summary", { textContent: capitalized(title) }), ...children);
    made.ontoggle = () => (made.open ? this.open.add(key) : this.open.delete(key));
    return made;
  }

  settings(object) {
    return this.scene.catalogue.settings.map((parameter) => {
      const { name } = parameter;
      let first = true;
      const set = (value) => {
        this.scene.set(object.name, name, value, first);
        first = false;
      };
      const row = slider(parameter, object.settings[name] ?? parameter.default, parameter.default, set, () => {
        this.scene.set(object.name, name, parameter.default);
        this.show();
      });
      row.addEventListener("change", () => {
        first = true;
        if (name === "tune" || name === "decay") this.scene.look(object);
      });
      return row;
    });
  }

  gesture(object, name, { argument, keys, along, rolls, what }) {
    const chosen = this.hands.chosen[name];
    const usual = what?.length ? null : this.hands.usual(object, name);
    const rows = [argument, ...keys.filter((key) => !HIDDEN.has(key.name))].map((parameter) =>
      this.choice(chosen, parameter, parameter === argument ? usual : parameter.default));
    if (along) rows.splice(1, 0, this.surface(chosen, rolls ? "by material" : "wood"));
    if (what?.length) rows.unshift(this.support(chosen, what));
    const act = el("button", { className: "act", textContent: capitalized(VERBS[name] ?? name) });
    act.onclick = () => this.act(object, name);
    return [...rows, act];
  }

  choice(chosen, parameter, usual) {
    const { name } = parameter;
    return slider(parameter, chosen[name] ?? null, usual, (value) => (chosen[name] = value), () => {
      delete chosen[name];
      this.show();
    });
  }

  surface(chosen, otherwise) {
    const options = this.scene.catalogue.surfaces.map((each) => [each, each.replaceAll("-", " ")]);
    return this.word(chosen, "surface", [["", otherwise], ...options]);
  }

  /** What an object rests on: a support, or another object of the scene. */
  support(chosen, supports) {
    const others = [...this.scene.objects.keys()].filter((name) => name !== this.scene.selected);
    return this.word(chosen, "what", [...supports, ...others].map((each) => [each, each.replaceAll("-", " ")]));
  }

  /** A key that is one of some words, each a value and its text. */
  word(chosen, key, options) {
    const select = el("select", { "aria-label": key }, ...options.map(([value, textContent]) => el("option", { value, textContent })));
    select.value = chosen[key] ?? options[0][0];
    select.onchange = () => (select.value ? (chosen[key] = select.value) : delete chosen[key]);
    return el("label", { className: "slider" }, el("span", { textContent: key }), select);
  }

  /** The contact law, for all gestures alike. */
  law() {
    const { keys } = this.scene.catalogue.gestures.impact;
    return keys.filter(({ name }) => LAW.includes(name)).map((parameter) => {
      const { name } = parameter;
      const all = Object.values(this.hands.chosen);
      return slider(parameter, all[0][name] ?? null, null, (value) => all.forEach((each) => (each[name] = value)), () => {
        all.forEach((each) => delete each[name]);
        this.show();
      });
    });
  }

  main() {
    return slider(this.scene.catalogue.gain, this.gain ?? 0, 0, (value) => this.scene.link.steer("/gain", (this.gain = value)));
  }

  act(object, name) {
    const id = this.hands.play(object, name, object.preset.position);
    if (this.scene.catalogue.gestures[name].lasts) setTimeout(() => this.hands.stop(id), LASTS);
  }
}
