// Messages of the program as they come, whatever they come by.

import { kindOf, readSurface } from "./wire.js";

/** Hands messages to `on`: state("live") and hello(hello, surface) with the greeting, device(message),
 * text(message), frame(buffer). */
export class Reading {
  constructor(on) {
    this.on = on;
    this.begin();
  }

  /** From now on another program speaks, which greets first. */
  begin() {
    this.hello = null;
    this.isGreeted = false;
  }

  /** Takes a message; true for the one that completes the greeting. */
  take(data) {
    if (typeof data === "string") {
      const message = JSON.parse(data);
      if (message.type === "hello") this.hello = message;
      else if (message.type === "device") this.on.device(message);
      else if (message.type !== "alive") this.on.text(message);
      return false;
    }
    if (kindOf(data) !== 1) {
      this.on.frame(data);
      return false;
    }
    this.on.state("live");
    this.on.hello(this.hello, readSurface(data));
    this.isGreeted = true;
    return true;
  }
}
