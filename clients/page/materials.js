// How materials look: base, light and dark colours, and how clear they are.

const LOOKS = {
  "bell-bronze": ["#b9813b", "#f7d79b", "#5b3712"],
  brass: ["#c8a145", "#fff0b8", "#6d5213"],
  steel: ["#94a1ae", "#eef5fb", "#46515d"],
  "spring-steel": ["#7d8b99", "#dfe9f2", "#38434e"],
  iron: ["#50555c", "#a3abb4", "#212428"],
  aluminium: ["#b9c3cc", "#ffffff", "#6b767f"],
  tin: ["#a7aeb4", "#f3f6f8", "#5d646a"],
  glass: ["#9fd9e8", "#f2fdff", "#4b93a8", 0.42],
  polycarbonate: ["#a9c6f5", "#f3f8ff", "#5577b5", 0.42],
  ceramic: ["#e3d6c2", "#fffaf1", "#9c8c74"],
  wood: ["#b9854d", "#e6bd85", "#6d4520"],
  rosewood: ["#7d3d2a", "#c07a58", "#3a170e"],
  mylar: ["#e9e0cd", "#fffdf6", "#a3977e"],
  plastic: ["#d65a49", "#ffb1a3", "#7d251a"],
  rubber: ["#3b3d44", "#74777f", "#16171a"],
  "piano-wire": ["#a9adb6", "#f4f6f9", "#585c66"],
};
const UNKNOWN = ["#948a80", "#ddd4ca", "#4d463f"];

/** The look of a material: {base, light, dark, alpha, wooden}. */
export function look(material) {
  const [base, light, dark, alpha = 1] = LOOKS[material] ?? UNKNOWN;
  return { base, light, dark, alpha, wooden: material === "wood" || material === "rosewood" };
}

/** A gradient across a body, from dark over light to dark, as a round or polished one shines. */
export function sheen(g, x0, y0, x1, y1, { base, light, dark }) {
  const shade = g.createLinearGradient(x0, y0, x1, y1);
  shade.addColorStop(0, base);
  shade.addColorStop(0.28, light);
  shade.addColorStop(0.5, base);
  shade.addColorStop(1, dark);
  return shade;
}

/** A gradient around a point, as a round plate of metal shines. */
export function disc(g, r, { base, light, dark }) {
  const shade = g.createRadialGradient(-0.35 * r, -0.4 * r, 0.05 * r, 0, 0, 1.05 * r);
  shade.addColorStop(0, light);
  shade.addColorStop(0.45, base);
  shade.addColorStop(1, dark);
  return shade;
}
