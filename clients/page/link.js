// The connection to the server: OSC in binary frames of a web socket, which comes back by itself.

import { decode, encode } from "./osc.js";

const MOST_UNSENT = 1 << 16; // bytes: over a slow connection what would come too late is left out

export class Link extends EventTarget {
  constructor() {
    super();
    this.client = "";
    this.sent = 0;
    this.skipped = 0;
    this.heard = new Map();
    this.wait = 250;
    this.syncs = new Map();
    this.syncCount = 0;
    this.on("/synced", (id) => this.synced(id));
  }

  /** Have a function called with the arguments of each message to an address. */
  on(address, act) {
    if (!this.heard.has(address)) this.heard.set(address, []);
    this.heard.get(address).push(act);
  }

  get address() {
    return `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/`;
  }

  open() {
    this.socket = new WebSocket(this.address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onmessage = ({ data }) => this.take(data);
    this.socket.onclose = () => {
      this.dispatchEvent(new Event("lost"));
      for (const id of [...this.syncs.keys()]) this.synced(id);
      setTimeout(() => this.open(), this.wait);
      this.wait = Math.min(2 * this.wait, 2000);
    };
  }

  take(data) {
    if (typeof data === "string") {
      const { COMMAND, DATA } = JSON.parse(data);
      if (COMMAND === "CLIENT") {
        this.client = DATA;
        this.wait = 250;
        this.dispatchEvent(new Event("open"));
      }
      return;
    }
    const { address, args } = decode(data);
    for (const act of this.heard.get(address) ?? []) act(...args);
  }

  get isOpen() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  /** Send a message; `may be lost` ones only while nothing piles up. */
  send(address, ...args) {
    if (!this.isOpen) return false;
    this.socket.send(encode(address, ...args));
    this.sent++;
    return true;
  }

  /** Send a message that a later one makes up for, unless earlier ones still wait. */
  steer(address, ...args) {
    if (this.isOpen && this.socket.bufferedAmount > MOST_UNSENT) {
      this.skipped++;
      return false;
    }
    return this.send(address, ...args);
  }

  /** Wait until the server has done all that was sent before, or the connection is lost. */
  sync() {
    const id = ++this.syncCount;
    return new Promise((resolve) => {
      this.syncs.set(id, resolve);
      if (!this.send("/sync", id)) this.synced(id);
    });
  }

  synced(id) {
    this.syncs.get(id)?.();
    this.syncs.delete(id);
  }

  command(COMMAND, DATA) {
    if (this.isOpen) this.socket.send(JSON.stringify({ COMMAND, DATA }));
  }
}
