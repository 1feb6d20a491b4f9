// The tables that this browser keeps by their names, and the way of a table into a file and back.

import { el } from "./dom.js";
import { read } from "./tables.js";

const KEPT = "carom-tables";

export class Shelf {
  /** `openFile` and `saveFile`: take a file, and give one with a name. */
  constructor(dialog, scene, openFile, saveFile) {
    this.scene = scene;
    const part = (id) => dialog.querySelector(`#table-${id}`);
    [this.list, this.name] = [part("list"), part("name")];
    document.getElementById("tables-open").onclick = () => {
      this.show();
      dialog.showModal();
    };
    part("save").onclick = () => this.save();
    this.name.onkeydown = (event) => {
      if (event.key !== "Enter") return;
      event.preventDefault();
      this.save();
    };
    part("download").onclick = async () => {
      const title = this.title;
      saveFile(new Blob([await scene.freshText(title)], { type: "text/plain" }), `${title.replace(/[^\p{L}\p{N}_-]+/gu, "-")}.txt`);
    };
    part("clear").onclick = () => scene.replace([]);
    part("open").onclick = () => part("file").click();
    part("file").onchange = ({ target }) => {
      if (target.files[0]) openFile(target.files[0]);
      target.value = "";
      dialog.close();
    };
    this.dialog = dialog;
  }

  get title() {
    return this.name.value.trim() || "table";
  }

  get kept() {
    return JSON.parse(localStorage.getItem(KEPT) ?? "{}");
  }

  keep(tables) {
    localStorage.setItem(KEPT, JSON.stringify(tables));
    this.show();
  }

  async save() {
    this.keep({ ...this.kept, [this.title]: await this.scene.freshText(this.title) });
  }

  show() {
    const rows = Object.entries(this.kept).map(([name, text]) => {
      const table = read(text);
      const { objects } = table;
      const lay = el("button", { type: "button", className: "lay", title: objects.map((each) => each.name).join(", ") },
        el("span", { textContent: name }), el("span", { className: "quiet", textContent: `${objects.length} object${objects.length === 1 ? "" : "s"}` }));
      lay.onclick = () => {
        this.name.value = name;
        this.scene.open(table);
        this.dialog.close();
      };
      const forget = el("button", { type: "button", textContent: "Delete", "aria-label": `Delete ${name}` });
      forget.onclick = () => {
        const { [name]: _, ...others } = this.kept;
        this.keep(others);
      };
      return el("li", {}, lay, forget);
    });
    this.list.replaceChildren(...rows);
  }
}
