// A table as a score: it makes the objects where they lie, as comments say, and strikes each of them once.

export const HEAD = "# carom table";
const WORD = /^[A-Za-z_][\w.-]*$/;
const TOKEN = /"(?:\\.|[^"\\])*"|\[[^\]]*\]|#.*|\S+/g;
const EVERY = 0.8; // s between strikes

/** The score of a table: objects are {name, preset, keys, x, y, velocity, position}; `heard`: lines of who listens. */
export function write(title, objects, heard) {
  const lines = [
    `${HEAD}: ${title}`,
    "# Open it on Carom's page, or hear its objects: carom render table.txt table.wav",
  ];
  for (const { name, preset, keys, macros = {}, x, y } of objects) {
    lines.push(`# at ${x} ${y} ${name}`);
    lines.push(["0.0", "/object/new", written(name), written(preset), ...Object.entries(keys).flat().map(written)].join(" "));
    for (const [macro, value] of Object.entries(macros)) lines.push(`0.0 /object/${name}/macro/${macro} ${value}`);
  }
  lines.push(...heard);
  objects.forEach(({ name, velocity, position }, n) => {
    lines.push(`${(0.2 + EVERY * n).toFixed(1)} /object/${name}/impact ${velocity} ${position}`);
  });
  return `${lines.join("\n")}\n`;
}

function written(value) {
  if (Array.isArray(value)) return `[${value.map(written).join(" ")}]`;
  return typeof value === "number" || WORD.test(value) ? String(value) : JSON.stringify(value);
}

/** The table in a score: {title, objects, listener}, as `write` takes them; listener: {x, y, on}. An Error says why there
 * is none. */
export function read(text) {
  const [first, ...lines] = text.split(/\r?\n/);
  if (!first.startsWith(HEAD)) throw new Error(`expected a table, whose first line begins with "${HEAD}"`);
  const places = new Map();
  const objects = [];
  const listener = { on: false };
  for (const line of lines) {
    const [, u, v] = line.match(/^# listener at (\S+) (\S+)/) ?? [];
    if (u) Object.assign(listener, { x: within(u), y: within(v), on: true });
    const [, x, y, name] = line.match(/^# at (\S+) (\S+) (\S+)/) ?? [];
    if (name) places.set(name, [within(x), within(y)]);
    const [, address, ...args] = (line.match(TOKEN) ?? []).filter((token) => !token.startsWith("#")).map(valueOf);
    if (address === "/object/new") objects.push(made(args, places));
    const [, turned, macro] = String(address).match(/^\/object\/([^/]+)\/macro\/(\w+)$/) ?? [];
    const of = objects.find((each) => each.name === turned);
    if (of && Number.isFinite(args[0])) of.macros[macro] = args[0];
  }
  return { title: first.slice(HEAD.length).replace(/^:?\s*/, ""), objects, listener };
}

/** A share of the table's side, whatever a file says. */
function within(text) {
  return Number(text) >= 0 && Number(text) <= 1 ? Number(text) : 0.5;
}

function made([name, preset, ...pairs], places) {
  const keys = {};
  for (let n = 0; n + 1 < pairs.length; n += 2) keys[pairs[n]] = pairs[n + 1];
  const [x, y] = places.get(name) ?? [];
  return { name: String(name), preset: String(preset), keys, macros: {}, x, y };
}

function valueOf(token) {
  if (token.startsWith('"')) return JSON.parse(token);
  if (token.startsWith("[")) return (token.slice(1, -1).match(TOKEN) ?? []).map(valueOf);
  return /^[-+]?(\d|\.\d)/.test(token) && Number.isFinite(Number(token)) ? Number(token) : token;
}
