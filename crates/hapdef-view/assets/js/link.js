// The connection: greets with the token of the address, comes back when the server does.

import { kindOf, readSurface } from "./wire.js";

const FIRST_WAIT_MS = 250;
const LONGEST_WAIT_MS = 2000;
const CLOSE_TOKEN = 4401;

/** Connects for ever; `on` has hello(hello, surface), device(message), frame(buffer),
 * text(message), state(name). */
export class Link {
  constructor(on) {
    this.on = on;
    this.wait = FIRST_WAIT_MS;
    this.token = new URLSearchParams(location.hash.slice(1)).get("token");
    this.connect();
  }

  connect() {
    this.hello = null;
    const socket = new WebSocket(`ws://${location.host}/live`);
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => this.send({ cmd: "hello", token: this.token });
    socket.onmessage = (event) => this.read(event.data);
    socket.onclose = (event) => this.closed(event);
  }

  closed(event) {
    if (event.code === CLOSE_TOKEN) {
      this.on.state("locked");
      return;
    }
    this.on.state("away");
    setTimeout(() => this.connect(), this.wait);
    this.wait = Math.min(2 * this.wait, LONGEST_WAIT_MS);
  }

  read(data) {
    if (typeof data === "string") {
      const message = JSON.parse(data);
      if (message.type === "hello") this.hello = message;
      else if (message.type === "device") this.on.device(message);
      else this.on.text(message);
    } else if (kindOf(data) === 1) {
      this.wait = FIRST_WAIT_MS;
      this.on.state("live");
      this.on.hello(this.hello, readSurface(data));
    } else {
      this.on.frame(data);
    }
  }

  /** Sends a command; false: there is no connection. */
  send(message) {
    if (this.socket.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }
}
