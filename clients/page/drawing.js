// The drawing of bodies about the middle of a canvas's origin, as what they are.

import { look, disc as polished, sheen } from "./materials.js";

const TAU = 2 * Math.PI;

/** Pixels for a length in m: what is ten times as long is drawn three and a half times as long. */
export function pixels(metres) {
  return 150 * (metres / 0.3) ** 0.55;
}

export function shadowed(g, draw) {
  g.save();
  g.shadowColor = "rgba(0,0,0,.42)";
  g.shadowBlur = 16;
  g.shadowOffsetY = 7;
  draw();
  g.restore();
}

/** Lines of grain, or of brushed metal, within the current path. */
function grain(g, w, h, { dark, light, wooden }) {
  g.save();
  g.clip();
  g.globalAlpha *= wooden ? 0.26 : 0.06;
  g.lineWidth = wooden ? 1.1 : 0.7;
  for (let n = 0, y = -h / 2 + 2; y < h / 2; n++, y += wooden ? 4.1 + 2.3 * Math.sin(n * 1.7) : 3) {
    g.strokeStyle = n % 3 ? dark : light;
    g.beginPath();
    g.moveTo(-w / 2, y);
    const bend = wooden ? 3 * Math.sin(n * 2.3) : 0;
    g.bezierCurveTo(-w / 6, y + bend, w / 6, y - bend, w / 2, y + bend / 2);
    g.stroke();
  }
  g.restore();
}

function edged(g, { light, dark, alpha }) {
  g.globalAlpha = Math.min(1, alpha + 0.35);
  g.lineWidth = 1.2;
  g.strokeStyle = alpha < 1 ? light : dark;
  g.stroke();
  g.globalAlpha = 1;
}

export function bar(g, length, width, material, geometry) {
  const m = look(material);
  const tube = geometry.diameter !== undefined;
  const path = () => {
    g.beginPath();
    g.roundRect(-length / 2, -width / 2, length, width, tube ? width / 2 : Math.min(5, width / 5));
  };
  g.globalAlpha = m.alpha;
  shadowed(g, () => {
    g.fillStyle = sheen(g, 0, -width / 2, 0, width / 2, m);
    path();
    g.fill();
  });
  if (!tube) grain(g, length, width, m);
  path();
  edged(g, m);
  g.fillStyle = "rgba(0,0,0,.35)";
  if (geometry.ends === "cantilever") {
    g.beginPath();
    g.roundRect(-length / 2 - 8, -width / 2 - 7, 16, width + 14, 4);
    g.fill();
  } else if (!tube) {
    for (const x of [-0.276, 0.276]) { // where the first mode rests, and cords go through
      g.beginPath();
      g.arc(x * length, 0, Math.min(3, width / 8), 0, TAU);
      g.fill();
    }
  }
}

export function fork(g, length, width, material) {
  const m = look(material);
  g.lineJoin = "round";
  g.lineCap = "round";
  shadowed(g, () => {
    g.strokeStyle = sheen(g, 0, -width / 2, 0, width / 2, m);
    g.lineWidth = 8;
    g.beginPath();
    g.moveTo(length / 2, -width / 2 + 5);
    g.lineTo(-length * 0.12, -width / 2 + 5);
    g.arc(-length * 0.12, 0, width / 2 - 5, -Math.PI / 2, Math.PI / 2, true);
    g.lineTo(length / 2, width / 2 - 5);
    g.moveTo(-length * 0.12 - width / 2 + 5, 0);
    g.lineTo(-length / 2, 0);
    g.stroke();
  });
}

export function string(g, length, material) {
  const m = look(material);
  shadowed(g, () => {
    for (const side of [-1, 1]) {
      g.fillStyle = "#7a5433";
      g.beginPath();
      g.roundRect(side * (length / 2) - 7, -20, 14, 40, 5);
      g.fill();
    }
    g.strokeStyle = m.light;
    g.lineWidth = 2.6;
    g.beginPath();
    g.moveTo(-length / 2, 0);
    g.lineTo(length / 2, 0);
    g.stroke();
  });
  g.strokeStyle = m.dark;
  g.setLineDash([2, 2]);
  g.lineWidth = 2;
  g.globalAlpha = 0.5;
  g.beginPath();
  g.moveTo(-length / 2, 0);
  g.lineTo(length / 2, 0);
  g.stroke();
  g.setLineDash([]);
  g.globalAlpha = 1;
}

/** A flat body of rounded corners, with the grain of what has one. */
function slab(g, length, width, corner, m, grained) {
  const path = () => {
    g.beginPath();
    g.roundRect(-length / 2, -width / 2, length, width, corner);
  };
  g.globalAlpha = m.alpha;
  shadowed(g, () => {
    g.fillStyle = sheen(g, -length / 2, -width, length / 2, width, m);
    path();
    g.fill();
  });
  path();
  if (grained) grain(g, length, width, m);
  path();
  edged(g, m);
}

export function plate(g, length, width, material) {
  const m = look(material);
  slab(g, length, width, 5, m, m.alpha === 1);
  if (m.alpha < 1) {
    g.strokeStyle = "rgba(255,255,255,.5)";
    g.lineWidth = 2;
    for (const x of [-0.3, -0.2]) {
      g.beginPath();
      g.moveTo(x * length, -0.36 * width);
      g.lineTo((x - 0.1) * length, 0.1 * width);
      g.stroke();
    }
  }
}

export function disc(g, r, material, shape, name) {
  const m = look(material);
  const path = () => {
    g.beginPath();
    g.arc(0, 0, r, 0, TAU);
  };
  shadowed(g, () => {
    g.fillStyle = polished(g, r, m);
    path();
    g.fill();
  });
  g.save();
  if (shape === "membrane") {
    g.lineWidth = Math.max(6, r * 0.09);
    g.strokeStyle = name === "tom" ? "#8d2f3b" : "#8a5a30";
    path();
    g.stroke();
    g.lineWidth = 1.5;
    g.strokeStyle = "rgba(255,255,255,.35)";
    g.beginPath();
    g.arc(0, 0, r * 0.95, 0, TAU);
    g.stroke();
  } else {
    g.globalAlpha = 0.2;
    g.lineWidth = 0.8;
    for (let at = 0.16; at < 1; at += name === "cymbal" ? 0.045 : 0.09) {
      g.strokeStyle = m.dark;
      g.beginPath();
      g.arc(0, 0, at * r, 0, TAU);
      g.stroke();
    }
    g.globalAlpha = 1;
    path();
    edged(g, m);
    const dome = { cymbal: 0.24, gong: 0.3, "pot-lid": 0.14 }[name];
    if (dome) {
      g.fillStyle = polished(g, dome * r, m);
      g.beginPath();
      g.arc(0, 0, dome * r, 0, TAU);
      g.fill();
      edged(g, m);
    }
    if (name === "iron-pan") {
      g.fillStyle = m.dark;
      g.beginPath();
      g.roundRect(r - 4, -8, r * 0.7, 16, 8);
      g.fill();
    }
  }
  g.restore();
}

/** A solid ball; light falls through one that is clear. */
export function ball(g, r, material) {
  const m = look(material), clear = m.alpha < 1;
  const path = () => {
    g.beginPath();
    g.arc(0, 0, r, 0, TAU);
  };
  g.globalAlpha = clear ? 0.8 : 1;
  shadowed(g, () => {
    g.fillStyle = clear ? through(g, r, m) : polished(g, r, m);
    path();
    g.fill();
  });
  path();
  edged(g, m);
  g.globalAlpha = 0.85;
  g.fillStyle = "#ffffff";
  g.beginPath();
  g.ellipse(-0.38 * r, -0.46 * r, 0.2 * r, 0.11 * r, -0.7, 0, TAU);
  g.fill();
  g.globalAlpha = 1;
}

/** The shade of a clear ball: dark where the light enters, bright where it gathers on the other side. */
function through(g, r, { base, light, dark }) {
  const shade = g.createRadialGradient(0.3 * r, 0.4 * r, 0.05 * r, 0, 0, r);
  shade.addColorStop(0, light);
  shade.addColorStop(0.35, base);
  shade.addColorStop(0.85, dark);
  shade.addColorStop(1, base);
  return shade;
}

/** A body of no known shape: a rounded block. */
export function block(g, length, width, material) {
  const m = look(material);
  slab(g, length, width, width * 0.4, m, m.wooden);
}

export function ring(g, r, inner, material) {
  const m = look(material);
  shadowed(g, () => {
    g.fillStyle = sheen(g, -r, -r, r, r, m);
    g.beginPath();
    g.arc(0, 0, r, 0, TAU);
    g.arc(0, 0, inner, 0, TAU, true);
    g.fill();
  });
  edged(g, m);
}

/** A glass, a cup or a bowl, from the side and a little above. */
export function bowl(g, r, h, material, stem) {
  const m = look(material);
  const top = -h / 2;
  const deep = stem ? h * 0.52 : h;
  const narrow = stem ? 0.16 : 0.62;
  const path = () => {
    g.beginPath();
    g.moveTo(-r, top);
    g.bezierCurveTo(-r * 1.06, top + deep * 0.7, -r * narrow, top + deep, 0, top + deep * 1.02);
    g.bezierCurveTo(r * narrow, top + deep, r * 1.06, top + deep * 0.7, r, top);
    g.ellipse(0, top, r, r * 0.26, 0, 0, Math.PI, true);
  };
  g.globalAlpha = m.alpha;
  shadowed(g, () => {
    g.fillStyle = sheen(g, -r, 0, r, 0, m);
    path();
    g.fill();
    if (stem) {
      g.beginPath();
      g.roundRect(-3, top + deep, 6, h * 0.42, 3);
      g.ellipse(0, h / 2 - 2, r * 0.72, r * 0.16, 0, 0, TAU);
      g.fill();
    }
  });
  g.globalAlpha = Math.min(1, m.alpha + 0.25);
  g.fillStyle = m.alpha < 1 ? "rgba(255,255,255,.16)" : m.dark;
  g.beginPath();
  g.ellipse(0, top, r, r * 0.26, 0, 0, TAU);
  g.fill();
  edged(g, m);
  path();
  edged(g, m);
  g.strokeStyle = "rgba(255,255,255,.5)";
  g.lineWidth = 2.4;
  g.lineCap = "round";
  g.beginPath();
  g.moveTo(-r * 0.72, top + deep * 0.22);
  g.quadraticCurveTo(-r * 0.74, top + deep * 0.55, -r * 0.5, top + deep * 0.76);
  g.stroke();
}

export function bell(g, r, h, material) {
  const m = look(material);
  const [top, lip] = [-h / 2, h / 2 - r * 0.16];
  const path = () => {
    g.beginPath();
    g.moveTo(-r, lip);
    g.bezierCurveTo(-r * 0.78, lip - h * 0.2, -r * 0.62, top + h * 0.5, -r * 0.56, top + h * 0.28);
    g.bezierCurveTo(-r * 0.5, top + h * 0.1, -r * 0.26, top + h * 0.07, 0, top + h * 0.07);
    g.bezierCurveTo(r * 0.26, top + h * 0.07, r * 0.5, top + h * 0.1, r * 0.56, top + h * 0.28);
    g.bezierCurveTo(r * 0.62, top + h * 0.5, r * 0.78, lip - h * 0.2, r, lip);
    g.ellipse(0, lip, r, r * 0.16, 0, 0, Math.PI);
  };
  shadowed(g, () => {
    g.fillStyle = m.dark;
    g.beginPath();
    g.roundRect(-r * 0.2, top - h * 0.02, r * 0.4, h * 0.13, 8);
    g.fill();
    g.fillStyle = sheen(g, -r, 0, r, 0, m);
    path();
    g.fill();
  });
  g.save();
  path();
  g.clip();
  g.globalAlpha = 0.55;
  for (const [at, width] of [[0.27, 1.2], [0.3, 1.2], [0.72, 2], [0.76, 1], [0.86, 1.5]]) {
    g.strokeStyle = m.dark;
    g.lineWidth = width;
    g.beginPath();
    g.ellipse(0, top + at * h, r, r * 0.15, 0, 0, Math.PI);
    g.stroke();
  }
  g.restore();
  path();
  edged(g, m);
}

export function triangle(g, corners, material) {
  const m = look(material);
  g.lineCap = g.lineJoin = "round";
  shadowed(g, () => {
    g.strokeStyle = sheen(g, 0, -60, 0, 80, m);
    g.lineWidth = 10;
    g.beginPath();
    corners.forEach(([x, y]) => g.lineTo(x, y));
    g.stroke();
  });
}
