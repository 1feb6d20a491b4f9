// The shapes of objects: how large they are on the table, where a point of them lies along their strike path, and back.
// Lengths are in pixels about the middle of the body.

import { ball, bar, bell, block, bowl, disc, fork, pixels, plate, ring, string, triangle } from "./drawing.js";
import { meshBody } from "./meshes.js";

const TAU = 2 * Math.PI;
const SIZE = 0.2; // m, of a body of which only the modes are known

const clamp = (x, low = 0, high = 1) => Math.min(high, Math.max(low, x));

/** A long body, struck along its length. */
function long(length, width, draw, reach = width / 2 + 8) {
  return {
    w: length, h: Math.max(width, 24), draw,
    at: (x, y) => (Math.abs(y) <= Math.max(reach, 14) && Math.abs(x) <= length / 2 + 6 ? clamp(x / length + 0.5) : null),
    point: (p) => [(p - 0.5) * length, 0],
    cross: (g, p) => line(g, (p - 0.5) * length, -width / 2 - 4, (p - 0.5) * length, width / 2 + 4),
    glow: (g, p, step, style) => {
      g.fillStyle = style;
      g.fillRect((p - 0.5) * length, -width / 2, step * length + 1, width);
    },
  };
}

function line(g, x0, y0, x1, y1) {
  g.beginPath();
  g.moveTo(x0, y0);
  g.lineTo(x1, y1);
  g.stroke();
}

/** A round body that is struck along a diameter, from edge to edge. */
function round(r, draw) {
  return {
    w: 2 * r, h: 2 * r, draw,
    at: (x, y) => {
      const from = Math.hypot(x, y) / r;
      return from <= 1.04 ? clamp(0.5 + 0.5 * Math.min(1, from) * (x < 0 ? -1 : 1)) : null;
    },
    point: (p) => [(2 * p - 1) * r, 0],
    cross: (g, p) => circle(g, Math.abs(2 * p - 1) * r),
    glow: (g, p, step, style) => {
      if (p < 0.5) return;
      g.strokeStyle = style;
      g.lineWidth = 2 * step * r + 1;
      circle(g, (2 * p - 1 + step) * r);
    },
  };
}

function circle(g, r) {
  g.beginPath();
  g.arc(0, 0, Math.max(r, 0.5), 0, TAU);
  g.stroke();
}

/** A round body seen from above that is struck along half its rim. */
function rim(r, inner, draw) {
  const turn = (p) => Math.PI * (1 - p);
  return {
    w: 2 * r, h: 2 * r, draw,
    at: (x, y) => {
      const from = Math.hypot(x, y);
      return from <= r + 10 && from >= inner - 14 ? 1 - Math.abs(Math.atan2(y, x)) / Math.PI : null;
    },
    point: (p) => [r * 0.94 * Math.cos(turn(p)), -r * 0.94 * Math.sin(turn(p))],
    cross: (g, p) => {
      for (const side of [-1, 1]) {
        const [c, s] = [Math.cos(turn(p)), side * Math.sin(turn(p))];
        line(g, (inner - 5) * c, (inner - 5) * s, (r + 5) * c, (r + 5) * s);
      }
    },
    glow: (g, p, step, style) => {
      g.strokeStyle = style;
      g.lineWidth = r - inner;
      for (const side of [-1, 1]) {
        g.beginPath();
        g.arc(0, 0, (r + inner) / 2, side * turn(p), side * turn(p + step), side > 0);
        g.stroke();
      }
    },
  };
}

/** A standing body seen from the side, struck along the front of its rim: an ellipse at the height `top`. */
function standing(w, h, top, tilt, draw) {
  const r = w / 2;
  const turn = (p) => Math.PI * (1 - p);
  return {
    w, h, draw,
    at: (x, y) => (Math.abs(x) <= r + 6 && y >= -h / 2 - 8 && y <= h / 2 + 4 ? clamp(Math.acos(clamp(-x / r, -1, 1)) / Math.PI) : null),
    point: (p) => [r * Math.cos(turn(p)), top + tilt * Math.sin(turn(p))],
    cross: (g, p) => {
      const [x, y] = [r * Math.cos(turn(p)), top + tilt * Math.sin(turn(p))];
      line(g, x, y - 7, x, y + 9);
    },
    glow: (g, p, step, style) => {
      g.strokeStyle = style;
      g.lineWidth = 5;
      g.beginPath();
      g.ellipse(0, top, r, tilt, 0, turn(p), turn(p + step), true);
      g.stroke();
    },
  };
}

function plateBody(geometry, length, width, draw) {
  const [x0, y0] = geometry.path_from ?? [0, 0];
  const [x1, y1] = geometry.path_to ?? [1, 1];
  const ax = (x0 - 0.5) * length, ay = (0.5 - y0) * width;
  const dx = (x1 - x0) * length, dy = (y0 - y1) * width;
  const square = dx * dx + dy * dy;
  const half = Math.sqrt(square);
  const [nx, ny] = [-dy / half, dx / half];
  return {
    w: length, h: width, draw,
    at: (x, y) => (Math.abs(x) <= length / 2 + 6 && Math.abs(y) <= width / 2 + 6 ? clamp(((x - ax) * dx + (y - ay) * dy) / square) : null),
    point: (p) => [ax + p * dx, ay + p * dy],
    cross: (g, p) => line(g, ax + p * dx - 11 * nx, ay + p * dy - 11 * ny, ax + p * dx + 11 * nx, ay + p * dy + 11 * ny),
    path: (g) => line(g, ax, ay, ax + dx, ay + dy),
    glow: (g, p, step, style) => {
      g.save();
      g.beginPath();
      g.rect(-length / 2, -width / 2, length, width);
      g.clip();
      g.strokeStyle = style;
      g.lineWidth = step * half + 1;
      const [x, y] = [ax + (p + step / 2) * dx, ay + (p + step / 2) * dy];
      line(g, x - half * nx, y - half * ny, x + half * nx, y + half * ny);
      g.restore();
    },
  };
}

function triangleBody(length, material) {
  const side = pixels(length / 3) * 1.15;
  const high = side * 0.866;
  const corners = [[-side * 0.36, high / 2], [side / 2, high / 2], [0, -high / 2], [-side / 2, high / 2 - 10]];
  const spot = (p) => {
    const leg = Math.min(2, Math.floor(3 * p));
    const t = 3 * p - leg;
    return [0, 1].map((k) => corners[leg][k] * (1 - t) + corners[leg + 1][k] * t);
  };
  const near = (x, y) => {
    let [best, found] = [20, null];
    for (let p = 0; p <= 1; p += 0.01) {
      const [a, b] = spot(p);
      const far = Math.hypot(x - a, y - b);
      if (far < best) [best, found] = [far, p];
    }
    return found;
  };
  const dot = (g, p, size) => {
    g.beginPath();
    g.arc(...spot(clamp(p)), size, 0, TAU);
    g.fill();
  };
  return {
    w: side, h: high, metres: length / 3, draw: (g) => triangle(g, corners, material), at: near, point: spot,
    cross: (g, p) => { g.fillStyle = g.strokeStyle; dot(g, p, 3); },
    glow: (g, p, _, style) => { g.fillStyle = style; dot(g, p, 5); },
  };
}

/** The body of an object of a preset, as its shape, its geometry and its material have it: size, drawing, and the way
 * between its points and its strike path. `metres`: its width; `key`: alike for those that look alike. */
export function bodyOf({ shape, geometry, name, material, surface, view }) {
  if (surface) return keyed(meshBody(surface, material, view), name, material);
  const body = shaped(shape, geometry, name, material);
  const metres = geometry.radius ? 2 * geometry.radius : geometry.length ?? SIZE; // a ring's length is across
  return { metres, ...body, key: JSON.stringify([shape, geometry, name, material]) };
}

/** A body that is turned with a key for each side that one sees. */
function keyed(body, ...named) {
  const { view, turned } = body;
  return { ...body, key: JSON.stringify([...named, view]), turned: (...by) => keyed(turned(...by), ...named) };
}

function shaped(shape, geometry, name, material) {
  const size = (key, other = 0.1) => geometry[key] ?? other;
  const r = pixels(2 * size("radius")) / 2;
  if (shape === "string") {
    const length = pixels(size("length", 1)) * 0.92;
    return long(length, 10, (g) => string(g, length, material), 26);
  }
  if (shape === "bar") return barBody(geometry, size, name, material);
  if (shape === "plate") {
    const length = pixels(size("length"));
    const width = length * (size("width") / size("length"));
    return plateBody(geometry, length, width, (g) => plate(g, length, width, material));
  }
  if (shape === "disc" || shape === "membrane") return round(r, (g) => disc(g, r, material, shape, name));
  if (shape === "sphere") return round(r, (g) => ball(g, r, material));
  if (shape === "ring") {
    const outer = r + 6;
    const inner = outer * (1 - Math.max(0.16, size("thickness", 0.005) / size("radius")));
    return rim(outer, inner, (g) => ring(g, outer, inner, material));
  }
  if (shape === "glass" || shape === "can") {
    const stem = name.includes("wine");
    const h = 2 * r * (size("height") / (2 * size("radius"))) * (stem ? 1.9 : 1);
    return standing(2 * r, h + r * 0.5, -h / 2, r * 0.26, (g) => bowl(g, r, h, material, stem));
  }
  if (name.includes("bell") && geometry.radius && geometry.height) {
    const h = 2 * r * (geometry.height / (2 * geometry.radius)) * 1.1;
    return standing(2 * r, h, h / 2 - r * 0.16, r * 0.16, (g) => bell(g, r, h, material));
  }
  const length = pixels(size("length", geometry.radius ? 2 * geometry.radius : SIZE));
  return long(length, 0.5 * length, (g) => block(g, length, 0.5 * length, material));
}

function barBody(geometry, size, name, material) {
  const length = pixels(size("length"));
  if (name === "triangle") return triangleBody(size("length"), material);
  const width = Math.max(12, length * Math.min(0.4, size("diameter", size("width", 0.02)) / size("length")));
  if (name === "tuning-fork") {
    const [whole, wide] = [1.35 * length, 3.2 * width];
    return { ...long(whole, wide, (g) => fork(g, whole, wide, material)), metres: 1.35 * size("length") };
  }
  return long(length, width, (g) => bar(g, length, width, material, geometry));
}
