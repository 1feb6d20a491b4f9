// MIDI keyboards: each note strikes a copy of an object that is tuned to it, and the wheel is a hand on the object.

import { el } from "./dom.js";

const NAMES = ["C", "C♯", "D", "D♯", "E", "F", "F♯", "G", "G♯", "A", "A♯", "B"];
const SELECTED = "", BY_CHANNEL = "#";
const NOTE_ON = 0x90, CONTROL = 0xb0;
const WHEEL = 1, SILENCE = 120; // controllers; from the second on all silence

export class Midi {
  constructor(dialog, button, scene, hands, silence) {
    const part = (id) => dialog.querySelector(`#midi-${id}`);
    Object.assign(this, { button, scene, hands, silence, played: SELECTED, access: null });
    [this.state, this.connect, this.target, this.last] = ["state", "connect", "target", "last"].map(part);
    button.onclick = () => {
      this.show();
      dialog.showModal();
    };
    this.connect.onclick = () => this.listen();
    this.target.onchange = () => (this.played = this.target.value);
    scene.addEventListener("changed", () => this.choices());
    this.choices();
    this.listenIfAllowed();
  }

  async listenIfAllowed() {
    if (!navigator.requestMIDIAccess) return;
    const permission = await navigator.permissions?.query({ name: "midi" }).catch(() => null);
    if (permission?.state === "granted") this.listen();
  }

  /** Listen to all inputs, also to those that come later. */
  async listen() {
    try {
      this.access = await navigator.requestMIDIAccess();
    } catch (error) {
      this.state.textContent = `No MIDI in this browser: ${error.message}`;
      return;
    }
    this.access.onstatechange = () => this.attend();
    this.attend();
  }

  attend() {
    for (const input of this.access.inputs.values()) input.onmidimessage = ({ data }) => this.hear(data);
    this.show();
  }

  show() {
    const names = [...(this.access?.inputs.values() ?? [])].filter(({ state }) => state !== "disconnected").map(({ name }) => name);
    this.button.setAttribute("aria-pressed", String(names.length > 0));
    this.connect.hidden = !navigator.requestMIDIAccess || this.access !== null;
    if (names.length) this.state.textContent = `Listening to ${names.join(", ")}.`;
    else if (this.access) this.state.textContent = "No keyboard found: connect one.";
    else if (!navigator.requestMIDIAccess) this.state.textContent = missing();
  }

  choices() {
    if (this.played !== BY_CHANNEL && !this.scene.objects.has(this.played)) this.played = SELECTED;
    this.target.replaceChildren(
      el("option", { value: SELECTED, textContent: "the selected object" }),
      el("option", { value: BY_CHANNEL, textContent: "by channel: 1 the first object, 2 the second, …" }),
      ...[...this.scene.objects.keys()].map((name) => el("option", { value: name, textContent: name.replaceAll("-", " ") })));
    this.target.value = this.played;
  }

  /** The object that a channel plays, from 0 on. */
  object(channel) {
    const { objects, selected } = this.scene;
    return this.played === BY_CHANNEL ? [...objects.values()][channel] : objects.get(this.played || selected);
  }

  hear([status, first, second]) {
    const kind = status & 0xf0;
    if (kind === CONTROL && first >= SILENCE) this.silence();
    const object = this.object(status & 0x0f);
    if (!object) return;
    if (kind === NOTE_ON && second > 0) {
      this.hands.note(object, first, second);
      const note = `${NAMES[first % 12]}${Math.floor(first / 12) - 1}`;
      this.last.textContent = `${note} on ${object.name.replaceAll("-", " ")}, velocity ${second}`;
    } else if (kind === CONTROL && first === WHEEL) this.hands.damp(object, second / 127);
  }
}

function missing() {
  if (isSecureContext) return "This browser has no MIDI.";
  return "From another machine browsers allow MIDI over https only: start carom page --bind 0.0.0.0 --tls.";
}
