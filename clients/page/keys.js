// The computer's keyboard.

const PIANO = "awsedftgyhujkolp";
const STEP = 0.02;
const TURN = Math.PI / 12; // rad for an arrow key

export class Keys {
  constructor(scene, hands, table, silence) {
    Object.assign(this, { scene, hands, table, silence, octave: 4, held: new Map() });
    addEventListener("keydown", (event) => this.down(event));
    addEventListener("keyup", (event) => this.up(event));
    addEventListener("blur", () => [...this.held.keys()].forEach((key) => this.release(key)));
  }

  get selected() {
    return this.scene.objects.get(this.scene.selected);
  }

  down(event) {
    if (event.target.closest("input, select, textarea, dialog") || event.metaKey) return;
    if (event.ctrlKey) {
      if (event.key === "z") this.scene.undo();
      return;
    }
    const key = event.key.toLowerCase();
    const pill = event.target.closest(".pill");
    if (pill && this.onPill(key, event, this.scene.objects.get(pill.dataset.name))) {
      event.preventDefault();
      return;
    }
    if (event.repeat) return;
    if (event.key === "Escape") this.silence();
    else if (event.key === "?") document.getElementById("help").click();
    else if (/^[1-9]$/.test(key)) this.strikeNumber(Number(key), event.timeStamp);
    else if (key === "z" || key === "x") this.octave = Math.max(0, Math.min(8, this.octave + (key === "x" ? 1 : -1)));
    else if (PIANO.includes(key) && this.selected) this.hands.note(this.selected, 12 * (this.octave + 1) + PIANO.indexOf(key), event.shiftKey ? 120 : 90);
  }

  strikeNumber(number, stamp) {
    const object = [...this.scene.objects.values()][number - 1];
    if (object) {
      this.hands.strike(object, object.preset.position, undefined, stamp);
      this.scene.choose(object.name);
    }
  }

  /** What a key does on an object's name; true if anything. */
  onPill(key, event, object) {
    const { position } = object.preset;
    const step = { arrowleft: [-STEP, 0], arrowright: [STEP, 0], arrowup: [0, -STEP], arrowdown: [0, STEP] }[key];
    if (step && event.shiftKey) this.table.turn(object, TURN * Math.sign(step[0]), TURN * Math.sign(step[1]));
    else if (step) {
      this.scene.place(object.name, object.x + step[0], object.y + step[1]);
      this.scene.moved(object.name);
    } else if (key === "delete" || key === "backspace") this.scene.remove(object.name);
    else if (event.repeat) return ["enter", " ", "h", "b"].includes(key);
    else if (key === "enter" || key === " ") this.hands.strike(object, position);
    else if (key === "b") this.hands.drop(object, position);
    else if (key === "h") this.held.set("h", this.hands.press(object, position));
    else return false;
    return true;
  }

  up(event) {
    this.release(event.key.toLowerCase());
  }

  release(key) {
    if (this.held.has(key)) this.hands.stop(this.held.get(key));
    this.held.delete(key);
  }
}
