// The connection: greets with the token of the address, comes back when the server does.

import { Reading } from "./reading.js";

const FIRST_WAIT_MS = 250;
const LONGEST_WAIT_MS = 2000;
const CLOSE_TOKEN = 4401;
/** Without a sign of life for so long the program does not answer; it sends one every half second. */
const SILENT_MS = 1500;
/** A connection that says nothing for so long is given up. */
const DEAD_MS = 10000;
const LOOK_MS = 250;

/** Where the program speaks: beside the page. */
function address() {
  const url = new URL("live", location.href);
  url.protocol = "ws:";
  return url.href;
}

/** Connects for ever; `on` has hello(hello, surface), device(message), frame(buffer),
 * text(message), state(name). */
export class Link {
  constructor(on) {
    this.on = on;
    this.reading = new Reading(on);
    this.wait = FIRST_WAIT_MS;
    this.token = new URLSearchParams(location.hash.slice(1)).get("token");
    this.heard = performance.now();
    this.connect();
    setInterval(() => this.look(), LOOK_MS);
  }

  /** Whether the program still says something. */
  look() {
    const silent = performance.now() - this.heard;
    if (this.socket.readyState !== WebSocket.OPEN || silent < SILENT_MS) return;
    if (silent < DEAD_MS) this.on.state("silent");
    else this.socket.close();
  }

  connect() {
    this.reading.begin();
    const socket = new WebSocket(address());
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
    this.heard = performance.now();
    if (this.reading.isGreeted) this.on.state("live");
    if (this.reading.take(data)) this.wait = FIRST_WAIT_MS;
  }

  /** Sends a command; false: there is no connection. */
  send(message) {
    if (this.socket.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }
}
