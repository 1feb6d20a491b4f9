// Bodies of meshes, seen from a side that one turns: their picture, and the points of their surface under a finger.

import { pixels, shadowed } from "./drawing.js";
import { look } from "./materials.js";

const REACH = 10; // px beside the body, from which on a finger misses it
const FLAT = 0.35; // of the width: what is flatter is seen from above
const LOW = 0.4, HIGH = 1.0; // rad above the horizon
const STEEP = 1.5; // rad: no view is from straight above
const LIGHT = [-0.35, -0.6, -0.72]; // to the light: right, down, away
const SHINY = 24;
const EDGE = 0.7; // cosine of the angle from which on two triangles meet in an edge
const SEAM = 0.8; // px

const clamp = (x, low, high) => Math.min(high, Math.max(low, x));
const mean = ([a, b, c], k) => (a[k] + b[k] + c[k]) / 3;
const hex = (color) => [1, 3, 5].map((n) => parseInt(color.slice(n, n + 2), 16));

/** From above where the body is flat, else from the front; the longer side lies across. */
function usualView(sizes) {
  const [x, y, z] = sizes;
  return { turn: y > x ? Math.PI / 2 : 0, tilt: z < FLAT * Math.min(x, y) || z < FLAT * FLAT * Math.max(x, y) ? HIGH : LOW };
}

/** Weights of the corners at a pixel: all of them positive inside the triangle. */
function weights([[ax, ay], [bx, by], [cx, cy]], x, y) {
  const area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
  if (Math.abs(area) < 1e-9) return null;
  const b = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area;
  const c = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area;
  return [1 - b - c, b, c];
}

/** Weights of the corners at the pixel of a triangle's side from one corner to the next that is nearest to another. */
function onSide(corners, n, x, y) {
  const [[ax, ay], [bx, by]] = [corners[n], corners[(n + 1) % 3]];
  const square = (bx - ax) ** 2 + (by - ay) ** 2;
  const t = square ? clamp(((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / square, 0, 1) : 0;
  const found = [0, 0, 0];
  [found[n], found[(n + 1) % 3]] = [1 - t, t];
  return found;
}

/** A normal of a triangle, to either side; as long as twice the area. */
function normalOf([a, b, c]) {
  const [u, v] = [b, c].map((each) => each.map((value, k) => value - a[k]));
  return [0, 1, 2].map((k) => u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]);
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = (a) => a.map((each) => each / (Math.hypot(...a) || 1));

/** Each triangle's unit normal, the mean over those about it that turn off by less than an edge does. */
function smoothed({ points, faces }) {
  const flat = faces.map((face) => normalOf(face.map((k) => points[k])));
  const units = flat.map(unit);
  const about = new Map();
  faces.forEach((face, n) => face.forEach((k) => about.set(k, [...(about.get(k) ?? []), n])));
  return faces.map((face, n) => {
    const sum = [0, 0, 0];
    for (const other of new Set(face.flatMap((k) => about.get(k)))) {
      const turn = dot(units[n], units[other]);
      if (Math.abs(turn) > EDGE) flat[other].forEach((each, k) => (sum[k] += Math.sign(turn) * each));
    }
    return unit(sum);
  });
}

/** The colour of what has a normal (right, down, away), lit from above the viewer. */
function shade(normal, { base, light, dark }) {
  const lit = clamp(dot(normal, LIGHT) * (normal[2] > 0 ? -1 : 1), 0, 1);
  const shine = 0.25 * lit + 0.75 * lit ** SHINY;
  const [low, middle, high] = [dark, base, light].map(hex);
  const mix = (k) => low[k] + (middle[k] - low[k]) * Math.min(1, 1.4 * lit) + (high[k] - middle[k]) * shine;
  return `rgb(${[0, 1, 2].map((k) => Math.round(mix(k))).join()})`;
}

/** Corners of a triangle that is wider by some pixels: no seam is left to the next one. */
function widened(corners) {
  const middle = [0, 1].map((k) => mean(corners, k));
  return corners.map((corner) => {
    const [x, y] = [0, 1].map((k) => corner[k] - middle[k]);
    const share = SEAM / (Math.hypot(x, y) || 1);
    return [corner[0] + share * x, corner[1] + share * y];
  });
}

function outline(g, corners) {
  g.beginPath();
  corners.forEach(([x, y]) => g.lineTo(x, y));
  g.closePath();
}

/** The body of a surface {points (m), faces} of a material, from the side that `view` says. Where others have a position
 * along their strike path it has points of the surface, [x, y, z] in m, as /object/NAME/impact takes them. */
export function meshBody(surface, material, view = null) {
  const { points } = surface;
  const ends = [0, 1, 2].map((k) => [Math.min(...points.map((each) => each[k])), Math.max(...points.map((each) => each[k]))]);
  const sizes = ends.map(([low, high]) => high - low);
  const scale = pixels(Math.max(...sizes)) / Math.max(...sizes);
  const middle = ends.map(([low, high]) => (low + high) / 2);
  return seenFrom(view ?? usualView(sizes), { surface, material, scale, middle, normals: smoothed(surface) });
}

/** The same of a form that is known. */
function seenFrom({ turn, tilt }, form) {
  const { surface: { points, faces }, material, scale, middle, normals } = form;
  const [c, s, up, out] = [Math.cos(turn), Math.sin(turn), Math.cos(tilt), Math.sin(tilt)];
  /** A direction as its parts to the right, down and away from the viewer. */
  const turned = ([x, y, z]) => [c * x - s * y, -(up * z + out * (s * x + c * y)), up * (s * x + c * y) - out * z];
  const seen = (point) => turned(point.map((each, k) => (each - middle[k]) * scale));
  const spots = points.map(seen);
  const triangles = faces.map((face) => face.map((n) => spots[n]));
  const half = [0, 1].map((k) => Math.max(...spots.map((each) => Math.abs(each[k]))));
  const [w, h] = half.map((each) => Math.max(24, 2 * each));
  let visible = null;

  /** The triangle that is seen at a pixel, and its corners' weights there; beside the body the nearest one. */
  function pick(x, y) {
    let [found, nearest, off] = [null, Infinity, REACH];
    triangles.forEach((corners, n) => {
      const inside = weights(corners, x, y);
      if (inside && Math.min(...inside) >= 0) {
        const away = inside.reduce((sum, each, k) => sum + each * corners[k][2], 0);
        if (away < nearest) [found, nearest, off] = [{ n, shares: inside }, away, 0];
      } else if (off > 0) {
        for (const shares of [0, 1, 2].map((k) => onSide(corners, k, x, y))) {
          const far = Math.hypot(...[x, y].map((each, k) => each - shares.reduce((sum, part, j) => sum + part * corners[j][k], 0)));
          if (far < off) [found, off] = [{ n, shares }, far];
        }
      }
    });
    return found;
  }

  /** The triangles of which nothing lies before the middle. */
  const front = () => (visible ??= triangles.map((_, n) => n).filter((n) => pick(mean(triangles[n], 0), mean(triangles[n], 1))?.n === n));

  function picture(g) {
    const m = look(material);
    const order = triangles.map((_, n) => n).sort((a, b) => mean(triangles[b], 2) - mean(triangles[a], 2));
    for (const n of order) {
      g.fillStyle = shade(turned(normals[n]), m);
      outline(g, widened(triangles[n]));
      g.fill();
    }
  }

  return {
    w, h, metres: w / scale, view: { turn, tilt },
    draw(g) {
      const sharp = Math.hypot(g.getTransform().a, g.getTransform().b);
      const image = document.createElement("canvas");
      Object.assign(image, { width: Math.ceil((w + 4) * sharp), height: Math.ceil((h + 4) * sharp) });
      const inner = image.getContext("2d");
      inner.setTransform(sharp, 0, 0, sharp, ((w + 4) * sharp) / 2, ((h + 4) * sharp) / 2);
      picture(inner);
      g.globalAlpha = Math.min(1, look(material).alpha + 0.2);
      shadowed(g, () => g.drawImage(image, -(w + 4) / 2, -(h + 4) / 2, w + 4, h + 4));
      g.globalAlpha = 1;
    },
    at(x, y) {
      const found = pick(x, y);
      return found && [0, 1, 2].map((k) => Number(found.shares.reduce((sum, each, j) => sum + each * points[faces[found.n][j]][k], 0).toFixed(5)));
    },
    /** Where a point is seen; of a position along a path, which the page is not told, the middle. */
    point: (place) => (Array.isArray(place) ? seen(place).slice(0, 2) : [0, 0]),
    /** The body as it is seen after so many radians about its upright axis, and up. */
    turned: (about, above) => seenFrom({ turn: turn + about, tilt: clamp(tilt + above, -STEEP, STEEP) }, form),
    /** Light where points swing, by their shares of the largest swing. */
    shine(g, swing, glow) {
      for (const n of front()) {
        const share = faces[n].reduce((sum, k) => sum + swing[k], 0) / 3;
        g.fillStyle = `rgba(255,176,72,${(0.62 * glow * share * share).toFixed(3)})`;
        outline(g, triangles[n]);
        g.fill();
      }
    },
    /** The lines along which a shape, given at the points, is 0. */
    nodes(g, shape) {
      g.beginPath();
      for (const n of front()) {
        const ways = [0, 1, 2].map((k) => [k, (k + 1) % 3]).filter(([i, j]) => shape[faces[n][i]] * shape[faces[n][j]] < 0);
        ways.forEach(([i, j], count) => {
          const [a, b] = [shape[faces[n][i]], shape[faces[n][j]]];
          const [x, y] = [0, 1].map((k) => (triangles[n][i][k] * b - triangles[n][j][k] * a) / (b - a));
          if (count) g.lineTo(x, y);
          else g.moveTo(x, y);
        });
      }
      g.stroke();
    },
    /** The number of the point that is nearest to a place. */
    nearest: (place) => points.reduce((best, each, n) => (away(each, place) < away(points[best], place) ? n : best), 0),
  };
}

const away = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
