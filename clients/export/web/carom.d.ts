/** The files of a scene, fetched and compiled. */
export interface Files {
  readonly module: WebAssembly.Module;
  readonly map: Map;
  readonly data: ArrayBuffer;
  readonly worklet: string;
  readonly tracker?: { readonly module: WebAssembly.Module; readonly end: number };
}

/** What a scene says of itself: its rate (Hz), channels, length (frames), and its title. */
export interface Map {
  readonly rate: number;
  readonly channels: number;
  readonly frames: number;
  readonly title: string;
}

/** An object of a scene: its preset, how it is struck if nothing else is said, and its place on a table, 0 to 1. */
export interface Body {
  readonly name: string;
  readonly description: string;
  readonly striker: string;
  readonly velocity: number;
  readonly position: number;
  readonly at?: readonly [number, number];
}

/** An argument of a message: a number, a name, or a list of numbers where a number may take its time. */
export type Argument = number | string | readonly number[];

export interface Options {
  /** As `Carom.fetch` returns them; fetched now if they are not given. */
  files?: Files;
  /** The folder of the scene, if it is not this module's. */
  folder?: string | URL;
  /** True (the default): all objects are there, and nothing is played. False: the score plays. */
  live?: boolean;
}

/** Coordinates along x, y and z. */
export type Three = readonly [number, number, number];

/** What happened to bodies since the beginning: blows, those and slides that nobody would have heard, slides and rolls that
 * began, what was left out with the level of the loudest (dB over 20 uPa; -200: none), and touches and frames without room. */
export interface Contacts {
  readonly blows: number;
  readonly faint: number;
  readonly slides: number;
  readonly leftOut: number;
  readonly loudest: number;
  readonly crowded: number;
  readonly bodies: number;
}

/** What goes on, and what was left out since the beginning. */
export interface Report {
  /** Null in a scene without bodies. */
  readonly contacts: Contacts | null;
  /** Share of real time that computing takes, of late. */
  readonly load: number;
  /** Frames computed; contacts that go on; objects that ring; commands that wait for their time. */
  readonly frames: number;
  readonly contacts: number;
  readonly sounding: number;
  readonly waiting: number;
  /** Contacts left out, as others that are heard better took all room; and the loudness of the loudest, LUFS (-200: none was). */
  readonly dropped: number;
  readonly loudest: number;
  /** Blows that did not make a plate swell, as too many plates swelled at once. */
  readonly linear: number;
  /** Commands that came after their time; and those of the score that the engine did not take. */
  readonly late: number;
  readonly refused: number;
}

/** An event `warning` is a CustomEvent whose `detail` says what was left out or not played, as a server's /warning does. */
export class Carom extends EventTarget {
  static fetch(folder?: string | URL): Promise<Files>;
  static open(context: BaseAudioContext, options?: Options): Promise<Carom>;
  readonly context: BaseAudioContext;
  readonly node: AudioWorkletNode;
  readonly map: Map;
  /** Resolves once the engine runs, with the memory it takes. */
  readonly ready: Promise<{ megabytes: number }>;
  readonly objects: Readonly<Record<string, Body>>;
  /** Send a message. Resolves to the id of the gesture that it begins, if that lasts; rejects with why it is refused. */
  send(address: string, ...args: Argument[]): Promise<string | undefined>;
  /** The same at a time of the scene, in s from its beginning. */
  at(time: number): { send(address: string, ...args: Argument[]): Promise<string | undefined> };
  /** Say where a body is, in this frame: place (m), quaternion w x y z, velocity (m/s), spin (rad/s). */
  move(body: string, position: Three, turn?: readonly [number, number, number, number], velocity?: Three, spin?: Three): void;
  /** Say that two bodies touch at a point in this frame, with the normal (of length 1) from a to b. Give the impulse of the
   * normal force in the frame (N s) or the speed at which they closed (m/s), or neither; and the slip (m/s), if it is known. */
  touch(a: string, b: string, point: Three, normal: Three, told?: { impulse?: number; speed?: number; slip?: number }): void;
  /** Say where the listener of bodies is (m), and which way his right ear points. */
  listen(position: Three, right: Three): void;
  /** Let the sound take at most a share of a core, 0 to 1; while it takes more, what is heard least is left out. */
  govern(share: number): void;
  /** End a frame that was so long (s). A contact that it has not reported has ended. Rejects with why it is refused. */
  frame(seconds: number): Promise<undefined>;
  /** What goes on, and what was left out since the beginning. */
  report(): Promise<Report>;
  /** Begin anew, with the score (`live: false`) or with its objects alone. */
  load(options: { live: boolean }): void;
}

/** Why a page can't play here, as a sentence; "" where it can. */
export function missing(): string;
