// The module beside the page, driven by a test: the same calls as those of the page's worker.
(async () => {
  const [module, model] = await Promise.all(["hapdef.wasm", "limb.model"].map(async (name) => (await fetch(`/${name}`)).arrayBuffer()));
  const { exports } = (await WebAssembly.instantiate(module)).instance;
  const kept = [];
  const write = (bytes) => {
    const at = exports.hapdef_alloc(bytes.length);
    new Uint8Array(exports.memory.buffer, at, bytes.length).set(bytes);
  };
  const message = () => new Uint8Array(exports.memory.buffer, exports.hapdef_message(), exports.hapdef_message_len()).slice();
  const base64 = (bytes) => btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""));
  const keep = () => {
    for (let kind = exports.hapdef_next(); kind !== 0; kind = exports.hapdef_next()) kept.push([kind, base64(message())]);
  };
  write(new Uint8Array(model));
  if (!exports.hapdef_open()) return new TextDecoder().decode(message());
  globalThis.program = {
    play(words, pictures, stride) {
      write(new TextEncoder().encode(JSON.stringify(words)));
      exports.hapdef_hear();
      for (let i = 0; i < pictures; i += 1) {
        exports.hapdef_step(stride);
        keep();
      }
    },
    said: () => kept,
    /** Time of each of `n` frames more, µs. */
    times: (n) => Array.from({ length: n }, () => {
      const began = performance.now();
      exports.hapdef_step(1);
      const took = performance.now() - began;
      while (exports.hapdef_next() !== 0);
      return 1000 * took;
    }),
  };
  return "open";
})()
