// The file of a baked scene, and what an engine says of all its scenes.

import { sumOf } from "./sum.js";
import { decoded } from "./tables.js";

const MAGIC = "carom 2\n";
const SUM = 32; // bytes of the checksum
const HEAD = MAGIC.length + SUM + 8; // bytes before the map
const NAME = "carom"; // of the section in which an engine has its rules

/** What an engine says of itself and of all its scenes. */
export function rulesOf(module) {
  const [told] = WebAssembly.Module.customSections(module, NAME);
  return JSON.parse(new TextDecoder().decode(told));
}

/** The map, with its tables of mode shapes, and the data of a scene's file, for an engine of some rules; an Error says why not. */
export function unpacked(buffer, rules) {
  const text = new TextDecoder(), bytes = new Uint8Array(buffer);
  if (text.decode(bytes.subarray(0, MAGIC.length)) !== MAGIC) throw new Error("expected a scene that Carom has baked");
  const rest = new Uint8Array(bytes.length - SUM);
  rest.set(bytes.subarray(0, MAGIC.length));
  rest.set(bytes.subarray(MAGIC.length + SUM), MAGIC.length);
  const sum = [...bytes.subarray(MAGIC.length, MAGIC.length + SUM)].map((each) => each.toString(16).padStart(2, "0")).join("");
  if (sumOf(rest) !== sum) throw new Error("the scene is damaged: its bytes are not those of its checksum; expected it as it was exported");
  const length = new DataView(buffer).getUint32(HEAD - 8, true);
  const map = JSON.parse(text.decode(bytes.subarray(HEAD, HEAD + length)));
  expectOwn(rules, map);
  const data = buffer.slice(HEAD + length);
  let left = 16 * rules.state.shapes;
  for (const [, rows, columns, terms] of map.tables) {
    const isTable = [rows, columns, terms].every((each) => Number.isInteger(each) && each > 0) && rows * columns <= rules.state.shapes;
    left -= rows * columns;
    if (!isTable || terms > rows || left < 0) throw new Error(`a table of ${rows} by ${columns}, of ${terms} terms: none of mode shapes`);
  }
  const values = decoded(map.tables, new Uint8Array(data), map.coded);
  const tables = map.tables.map(([first], n) => [first, values[n]]);
  return { map: { ...map, ...rules, engine: map.engine, tables }, data };
}

/** An Error says that a scene is of another engine: what it has for the memory would lie in wrong places there. */
export function expectOwn(rules, map) {
  if (rules.engine === map.engine) return;
  throw new Error(`the scene is of another engine; expected carom.wasm.lzma and scene.carom.lzma of one export`);
}
