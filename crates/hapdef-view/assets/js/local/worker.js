// The program of a page without a server: the limb's module, stepped as fast as time goes.

const MODULE = new URL("../hapdef.wasm", import.meta.url);
const MODEL = new URL("../limb.model", import.meta.url);
const LOOK_MS = 15;
/** Frames at a time; a program that is slower, or stood still, leaves time out. */
const MOST_FRAMES = 60;
/** Pictures that the page has not taken yet, at most. */
const MOST_WAITING = 3;

let program = null;
let waiting = 0;
let stepped = 0;
let began = 0;

addEventListener("message", ({ data }) => {
  if (data.cmd === "got") waiting = Math.max(0, waiting - 1);
  else hear(data);
});
start().catch(fail);

async function start() {
  const [module, model] = await Promise.all([load(MODULE), load(MODEL)]);
  program = (await WebAssembly.instantiate(module)).instance.exports;
  write(new Uint8Array(model));
  if (!program.hapdef_open()) throw new Error(new TextDecoder().decode(message()));
  tell();
  began = performance.now();
  setInterval(look, LOOK_MS);
}

async function load(url) {
  const answer = await fetch(url);
  if (!answer.ok) throw new Error(`${url}: ${answer.status} ${answer.statusText}`);
  return answer.arrayBuffer();
}

/** Frames that are due. */
function look() {
  if (waiting >= MOST_WAITING) return;
  const due = Math.floor((performance.now() - began) * program.hapdef_rate_hz() * 1e-3) - stepped;
  if (due <= 0) return;
  const n = Math.min(due, MOST_FRAMES);
  stepped += due;
  try {
    program.hapdef_step(n);
    tell();
  } catch (error) {
    fail(error);
  }
}

function hear(words) {
  write(new TextEncoder().encode(JSON.stringify(words)));
  program.hapdef_hear();
  tell();
}

function write(bytes) {
  const at = program.hapdef_alloc(bytes.length);
  new Uint8Array(program.memory.buffer, at, bytes.length).set(bytes);
}

/** Hands all messages to the page. */
function tell() {
  for (let kind = program.hapdef_next(); kind !== 0; kind = program.hapdef_next()) {
    const bytes = message();
    if (kind === 1) {
      postMessage(new TextDecoder().decode(bytes));
    } else {
      if (bytes[0] === 2) waiting += 1;
      postMessage(bytes.buffer, [bytes.buffer]);
    }
  }
}

/** A copy of the message that was taken. */
function message() {
  return new Uint8Array(program.memory.buffer, program.hapdef_message(), program.hapdef_message_len()).slice();
}

function fail(error) {
  postMessage({ failed: error.message || String(error) });
  close();
}
