// The connection of a page without a server: the program is a module in a worker of this browser.

import { Reading } from "./reading.js";

/** Starts the program; `on` has hello(hello, surface), device(message), frame(buffer), text(message),
 * state(name). */
export class Link {
  constructor(on) {
    this.on = on;
    this.reading = new Reading(on);
    this.worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
    this.worker.onmessage = ({ data }) => (data.failed ? this.fail(data.failed) : this.reading.take(data));
    this.worker.onerror = (event) => this.fail(event.message || "the program could not be loaded");
  }

  /** Nothing more will come. */
  fail(why) {
    this.worker.terminate();
    this.reading.begin();
    this.on.state("failed");
    this.on.device({ simulated: true, fault: why });
  }

  /** Sends a command; false: there is no program. */
  send(message) {
    if (!this.reading.isGreeted) return false;
    this.worker.postMessage(message);
    return true;
  }
}
