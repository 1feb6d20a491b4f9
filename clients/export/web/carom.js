// A scene that Carom has baked, in a page: no server, no special headers.

import { unpacked as plain } from "./lzma.js";
import { sumOf } from "./sum.js";
import { decoded } from "./tables.js";
import { joined } from "./wasm.js";

const MAGIC = "carom 2\n";
const SUM = 32; // bytes of the checksum
const HEAD = MAGIC.length + SUM + 8; // bytes before the map
const STORE = "carom"; // of decoded files, in browsers
const NAME = "carom"; // of the section in which an engine has its rules
const FILES = { engine: "carom.wasm.lzma", scene: "scene.carom.lzma", worklet: "worklet.js.lzma" };

/** The content of a file that was compressed as LZMA, which the browser keeps when it is decoded; last: what is done then. */
async function fetched(url, last = (content) => content) {
  const reply = await fetch(url);
  if (!reply.ok) throw new Error(`${url}: ${reply.status} ${reply.statusText}`);
  const made = ["ETag", "Last-Modified", "Content-Length"].map((name) => reply.headers.get(name) ?? "-").join(" ");
  const store = await globalThis.caches?.open(STORE).catch(() => null); // some windows have none
  const kept = await store?.match(url);
  if (kept?.headers.get("Made-Of") === made) {
    reply.body.cancel();
    return kept.arrayBuffer();
  }
  const { buffer } = last(plain(new Uint8Array(await reply.arrayBuffer())));
  store?.put(url, new Response(buffer, { headers: { "Made-Of": made } })).catch(() => {}); // there may be no room
  return buffer;
}

/** What an engine says of itself and of all its scenes. */
function rulesOf(module) {
  const [told] = WebAssembly.Module.customSections(module, NAME);
  return JSON.parse(new TextDecoder().decode(told));
}

/** The map and the data in the file of a baked scene, for an engine of some rules; the map has the tables of mode shapes
 * with their values. An Error says why the file is none. */
function unpacked(buffer, rules) {
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
function expectOwn(rules, map) {
  if (rules.engine === map.engine) return;
  throw new Error(`the scene is of another engine; expected ${FILES.engine} and ${FILES.scene} of one export`);
}

export class Carom extends EventTarget {
  /** The files of a scene, fetched and compiled: as early as the page likes, before anybody has touched it. */
  static async fetch(folder = new URL(".", import.meta.url)) {
    const at = (name) => new URL(name, new URL(folder, document.baseURI));
    const [module, scene, script] = await Promise.all([
      fetched(at(FILES.engine), joined).then(WebAssembly.compile),
      fetched(at(FILES.scene)),
      fetched(at(FILES.worklet)),
    ]);
    const found = unpacked(scene, rulesOf(module));
    const worklet = URL.createObjectURL(new Blob([script], { type: "text/javascript" }));
    return { module, ...found, worklet };
  }

  /** A scene that plays into a context, from its score's beginning, or with all its objects there (`live`). */
  static async open(context, { files, folder, live = true } = {}) {
    const found = files ?? (await Carom.fetch(folder));
    const { module, map, data, worklet } = found;
    expectOwn(rulesOf(module), map);
    if (context.sampleRate !== map.rate) {
      throw new Error(`sampleRate = ${context.sampleRate}: expected ${map.rate}: new AudioContext({ sampleRate: ${map.rate} })`);
    }
    await context.audioWorklet.addModule(worklet);
    const processorOptions = { module, map, data, live };
    const node = new AudioWorkletNode(context, "carom", { numberOfInputs: 0, outputChannelCount: [map.channels], processorOptions });
    return new Carom(context, node, map);
  }

  constructor(context, node, map) {
    super();
    Object.assign(this, { context, node, map, asked: new Map(), count: 0 });
    this.ready = new Promise((done, fail) => {
      this.stop = (reason) => {
        this.stopped = new Error(reason);
        for (const waiting of [{ fail }, ...this.asked.values()]) waiting.fail(this.stopped);
      };
      node.onprocessorerror = () => this.stop("the engine has stopped");
      this.done = done;
    });
    node.port.onmessage = ({ data }) => this.hear(data);
    node.connect(context.destination);
  }

  /** The names of the scene's objects, each with what is said of its preset. */
  get objects() {
    const { objects, presets } = this.map;
    return Object.fromEntries(Object.entries(objects).map(([name, each]) => [name, { ...presets[each.preset], at: each.at }]));
  }

  /** Send a message, as OSC has it; the id of the gesture that it begins, if it begins one that lasts. */
  send(address, ...args) {
    return this.tell({ address, args });
  }

  /** The same at a time of the scene, in s. */
  at(time) {
    return { send: (address, ...args) => this.tell({ address, args, at: time }) };
  }

  tell(message) {
    const ask = ++this.count;
    return new Promise((done, fail) => {
      if (this.stopped) throw this.stopped;
      if (this.context.state === "closed") throw new Error("the context is closed; expected one that plays");
      this.node.port.postMessage({ ...message, ask }); // it throws at what cannot be told: a function
      this.asked.set(ask, { done, fail });
    });
  }

  /** Begin anew: the score from its first line on, or its objects alone. */
  load({ live }) {
    this.node.port.postMessage({ load: live });
  }

  hear(told) {
    if (told.stopped) this.stop(told.stopped);
    if (told.ready) this.done(told);
    const waiting = this.asked.get(told.ask);
    this.asked.delete(told.ask);
    if (told.refused === undefined) waiting?.done(told.id);
    else waiting?.fail(new Error(told.refused));
  }
}
