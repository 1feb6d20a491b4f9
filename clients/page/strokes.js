// What a drag does to an object: it rolls or slides what is heard about as loud as a blow, at the speeds of a hand.

const NATURAL = 600; // px/s of a pointer, at which a slide has its usual speed

const BALL = { gesture: "roll", keys: { striker: "ball-bearing", surface: "wood", roughness: 1.5 } };
const ROUGHER = { gesture: "roll", keys: { ...BALL.keys, roughness: 3 } };
const ROUGHEST = { gesture: "roll", keys: { ...BALL.keys, roughness: 6 } };
const HEAVY = { gesture: "roll", keys: { striker: "clapper", surface: "asphalt", roughness: 3 } };
const SCRATCHED = { gesture: "slide", keys: { striker: "triangle-beater", surface: "sandpaper", force: 3 } };
const sanded = (force) => ({ gesture: "slide", keys: { striker: "sanding-block", surface: "sandpaper", force } });

/** The stroke of an object: its preset's roll or slide, else what suits its shape: {gesture, keys, usual}. */
export function strokeOn({ preset, material }) {
  const { shape, geometry, gestures: { roll, slide } = {} } = preset;
  if (roll) return { gesture: "roll", keys: { surface: roll.surface } };
  if (slide && shape === "bar" && slide.striker === "bow") return BALL; // a bar is bowed at one point of it
  if (slide) return { gesture: "slide", keys: {}, usual: slide.speed };
  if (shape === "string") return sanded(20);
  if (shape === "membrane" || shape === "sphere") return sanded(100);
  if (shape === "ring" || (shape === "bar" && geometry.diameter)) return SCRATCHED;
  if (shape === "bar" && geometry.ends === "cantilever") return ROUGHEST; // a tine hardly moves the air
  if (shape === "bar" && material !== "wood") return SCRATCHED;
  if (shape === "listed" && geometry.height > 0.3) return HEAVY;
  return shape === "bar" || (shape === "plate" && material === "wood") ? ROUGHER : BALL;
}

/** The speed (m/s) of a stroke whose pointer has a speed in m/s of the object, and in px/s. A bow's is not a hand's. */
export function speedOf({ usual }, metres, pixels) {
  return usual ? (usual * pixels) / NATURAL : metres;
}
