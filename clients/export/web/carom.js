// A scene that Carom has baked, in a page: no server, no special headers.

import { expectOwn, rulesOf, unpacked } from "./file.js";
import { unpacked as plain } from "./lzma.js";
import { joined } from "./wasm.js";

const STORE = "carom"; // of decoded files, in browsers
const FILES = { engine: "carom.wasm.lzma", tracker: "touch.wasm.lzma", scene: "scene.carom.lzma", worklet: "worklet.js.lzma" };

/** The browser's store and what it has of a file: nothing where it has none, or does not let a page have it. */
async function stored(url) {
  try {
    const store = await caches.open(STORE);
    return [store, await store.match(url)];
  } catch {
    return [];
  }
}

/** Why a page can't play here, as a sentence; "" where it can. */
export function missing() {
  if (location.protocol === "file:") return "A page that is opened as a file can't play: serve its folder, as by `python3 -m http.server`, and open it from there.";
  if (!globalThis.isSecureContext) return `A browser lets a page play over https, or from localhost: expected https in place of ${location.origin}.`;
  const parts = ["AudioContext", "AudioWorkletNode", "WebAssembly"].filter((name) => !(name in globalThis));
  return parts.length ? `This browser has no ${parts.join(", no ")}: expected a newer one, or one that is not locked down.` : "";
}

/** The content of a file that was compressed as LZMA, which the browser keeps when it is decoded; last: what is done then. */
async function fetched(url, last = (content) => content) {
  const reply = await fetch(url);
  if (!reply.ok) throw new Error(`${url}: ${reply.status} ${reply.statusText}`);
  const made = ["ETag", "Last-Modified", "Content-Length"].map((name) => reply.headers.get(name) ?? "-").join(" ");
  const [store, kept] = await stored(url);
  if (kept?.headers.get("Made-Of") === made) {
    reply.body?.cancel();
    return kept.arrayBuffer();
  }
  const { buffer } = last(plain(new Uint8Array(await reply.arrayBuffer())));
  store?.put(url, new Response(buffer, { headers: { "Made-Of": made } })).catch(() => {}); // there may be no room for it
  return buffer;
}

export class Carom extends EventTarget {
  /** The files of a scene, fetched and compiled: as early as the page likes, before anybody has touched it. */
  static async fetch(folder = new URL(".", import.meta.url)) {
    if (!globalThis.WebAssembly) throw new Error(missing());
    const at = (name) => new URL(name, new URL(folder, document.baseURI));
    const [module, scene, script] = await Promise.all([
      fetched(at(FILES.engine), joined).then(WebAssembly.compile),
      fetched(at(FILES.scene)),
      fetched(at(FILES.worklet)),
    ]);
    const found = unpacked(scene, rulesOf(module));
    const worklet = URL.createObjectURL(new Blob([script], { type: "text/javascript" }));
    const tracks = found.map.bodies && (await fetched(at(FILES.tracker), joined).then(WebAssembly.compile));
    const tracker = tracks && { module: tracks, end: rulesOf(tracks).data_end };
    return { module, ...found, worklet, tracker };
  }

  /** A scene that plays into a context, from its score's beginning, or with all its objects there (`live`). */
  static async open(context, { files, folder, live = true } = {}) {
    const found = files ?? (await Carom.fetch(folder));
    const { module, map, data, worklet, tracker } = found;
    expectOwn(rulesOf(module), map);
    if (missing()) throw new Error(missing());
    if (context.sampleRate !== map.rate) {
      throw new Error(`sampleRate = ${context.sampleRate}: expected ${map.rate}: new AudioContext({ sampleRate: ${map.rate} })`);
    }
    await context.audioWorklet.addModule(worklet);
    const processorOptions = { module, map, data, tracker, live };
    const node = new AudioWorkletNode(context, "carom", { numberOfInputs: 0, outputChannelCount: [map.channels], processorOptions });
    return new Carom(context, node, map);
  }

  constructor(context, node, map) {
    super();
    Object.assign(this, { context, node, map, asked: new Map(), count: 0, reported: { moves: [], touches: [] } });
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

  /** Say where a body is, in this frame: m, a quaternion w x y z, m/s, rad/s. */
  move(body, position, turn = [1, 0, 0, 0], velocity = [0, 0, 0], spin = [0, 0, 0]) {
    this.reported.moves.push([body, ...position, ...turn, ...velocity, ...spin]);
  }

  /** Say that two bodies touch at a point in this frame, with the normal from a to b. */
  touch(a, b, point, normal, { impulse = NaN, speed = NaN, slip = NaN } = {}) {
    this.reported.touches.push([a, b, ...point, ...normal, speed, slip, NaN, NaN, NaN, NaN, NaN, impulse]);
  }

  /** Say where the listener of bodies is, and which way his right ear points. */
  listen(position, right) {
    this.reported.listener = [...position, ...right];
  }

  /** Let the sound take at most a share of a core, 0 to 1. */
  govern(share) {
    this.reported.share = share;
  }

  /** End a frame that was so long (s). */
  frame(seconds) {
    const frame = { seconds, ...this.reported };
    this.reported = { moves: [], touches: [] };
    return this.tell({ frame });
  }

  /** What goes on, and what was left out so far. */
  report() {
    return this.tell({ report: true });
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
    if (told.warning) this.dispatchEvent(new CustomEvent("warning", { detail: told.warning }));
    const waiting = this.asked.get(told.ask);
    this.asked.delete(told.ask);
    if (told.refused === undefined) waiting?.done(told.report ?? told.id);
    else waiting?.fail(new Error(told.refused));
  }
}
