// The palettes: what a touch does, strikers to choose from, presets to hear, to add by a click, or to drag to the table.

import { bodyOf } from "./bodies.js";
import { el, short } from "./dom.js";
import { look } from "./materials.js";

const THUMB = 44;

function thumbnail(preset) {
  const body = bodyOf(preset);
  const dense = Math.min(window.devicePixelRatio || 1, 2);
  const canvas = el("canvas", { width: THUMB * dense, height: THUMB * dense, "aria-hidden": "true" });
  const g = canvas.getContext("2d");
  const s = (0.78 * THUMB * dense) / Math.max(body.w, body.h);
  g.translate((THUMB * dense) / 2, (THUMB * dense) / 2);
  g.scale(s, s);
  body.draw(g);
  return canvas;
}

/** The presets, to be found by name, heard, added and dragged. */
export function presets(list, search, scene, table) {
  for (const preset of scene.catalogue.objects) {
    const name = preset.name.replaceAll("-", " ");
    const hear = el("button", { className: "hear", textContent: "▸", title: `Hear ${name}`, "aria-label": `Hear ${name}` });
    hear.onclick = () => scene.hear(preset.name);
    const add = el("button", { className: "add", title: preset.description, "aria-label": `Add ${name}: ${preset.description}` },
      thumbnail(preset), el("span", { textContent: name }));
    add.onclick = () => add.dragged || scene.add(preset.name);
    draggable(add, preset, scene, table);
    list.append(el("li", { className: "preset" }, add, hear));
  }
  search.oninput = () => {
    const wanted = search.value.trim().toLowerCase();
    [...list.children].forEach((row, n) => {
      const { name, description, material, shape } = scene.catalogue.objects[n];
      row.hidden = !`${name} ${description} ${material} ${shape}`.toLowerCase().replaceAll("-", " ").includes(wanted);
    });
  };
}

/** Let a preset be dragged to a place on the table. */
function draggable(button, preset, scene, table) {
  button.onpointerdown = (down) => {
    button.dragged = false;
    let ghost = null;
    const move = (event) => {
      if (!ghost && Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY) > 10 && down.pointerType !== "touch") {
        ghost = thumbnail(preset);
        ghost.className = "ghost";
        document.body.append(ghost);
        button.dragged = true;
      }
      if (ghost) ghost.style.transform = `translate(${event.clientX - THUMB / 2}px, ${event.clientY - THUMB / 2}px)`;
    };
    const up = (event) => {
      removeEventListener("pointermove", move);
      removeEventListener("pointerup", up);
      if (!ghost) return;
      ghost.remove();
      setTimeout(() => (button.dragged = false));
      const [x, y] = table.spot(event);
      if (x > 0 && y > 0 && x < table.w && y < table.h) scene.add(preset.name, x / table.w, y / table.h);
    };
    addEventListener("pointermove", move);
    addEventListener("pointerup", up);
  };
}

/** The strikers, one of which is chosen. */
export function strikers(box, hands, onChosen) {
  const chips = [null, ...hands.scene.catalogue.strikers].map((striker) => {
    const name = striker ? striker.name.replaceAll("-", " ") : "each one's own";
    const dot = el("i", { "aria-hidden": "true" });
    if (striker) {
      const colors = look(striker.material);
      dot.style.background = `radial-gradient(circle at 35% 30%, ${colors.light}, ${colors.base} 45%, ${colors.dark})`;
    }
    const title = striker ? `${striker.description}; ${short(striker.mass * 1000)} g` : "Each object is struck by its own striker";
    const chip = el("button", { className: "chip", title }, dot, el("span", { textContent: name }));
    chip.onclick = () => {
      hands.striker = striker?.name ?? null;
      onChosen();
    };
    return chip;
  });
  choice(box, chips);
}

const TOUCHES = {
  rain: "Rain falls while you hold; move to move it",
  shake: "Shakes many copies of the striker in it while you hold",
  crumple: "Crushes it while you hold",
  shatter: "Breaks it: its pieces fall on a floor; set its damp to 0 to mend it",
  pour: "Pours many copies of the striker on it while you hold; move to move them",
  step: "Treads on it once, from heel to toe",
};

/** What a touch of an object does: it strikes, or many small blows fall. */
export function touches(box, hands) {
  const swarms = Object.keys(hands.gestures).filter((name) => hands.gestures[name].swarms);
  choice(box, [null, ...swarms].map((swarm) => {
    const chip = el("button", { className: "chip bare", title: swarm ? TOUCHES[swarm] ?? "" : "Tap, hold, drag: see How to play", textContent: swarm ?? "strike" });
    chip.onclick = () => (hands.swarm = swarm);
    return chip;
  }));
}

/** Let one of some chips be chosen, the first at first; each knows by its onclick what that means. */
function choice(box, chips) {
  for (const chip of chips) {
    const chosen = chip.onclick;
    chip.setAttribute("role", "radio");
    chip.setAttribute("aria-checked", String(chip === chips[0]));
    chip.onclick = () => {
      for (const each of chips) each.setAttribute("aria-checked", String(each === chip));
      chosen();
    };
  }
  box.append(...chips);
  box.onkeydown = (event) => {
    const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    const next = chips[(chips.indexOf(document.activeElement) + step + chips.length) % chips.length];
    next.focus();
    next.click();
  };
}
