// Messages of the server, byte by byte as docs/view.md has them. Little-endian.

const VERSION = 4;
const HEADER_BYTES = 76;
const MARK_BYTES = 80;
const PHASES = ["taring", "untouched", "touched", "unknown"];
/** Why a phase is unknown. */
const WHY = ["", "Too few gauges count to exclude a contact", "No readings come", "The tare is not valid", "Readings not explained", "The readings drift too fast"];

/** Kind of a binary message: 1 surface, 2 frame. */
export function kindOf(buffer) {
  const [kind, version] = new Uint8Array(buffer, 0, 2);
  if (version !== VERSION) throw new Error(`message version ${version}, this page reads ${VERSION}: load it again`);
  return kind;
}

/** The limb's surface. */
export function readSurface(buffer) {
  const view = new DataView(buffer);
  const n = view.getUint32(4, true);
  const m = view.getUint32(8, true);
  return {
    positions: new Float32Array(buffer, 16, 3 * n),
    normals: new Float32Array(buffer, 16 + 12 * n, 3 * n),
    triangles: new Uint32Array(buffer, 16 + 24 * n, 3 * m),
  };
}

/** Time of a frame, s. */
export const timeOf = (buffer) => new DataView(buffer).getFloat64(8, true);

/** A frame; arrays are views of the buffer. */
export function readFrame(buffer) {
  const view = new DataView(buffer);
  const f32 = (at) => view.getFloat32(at, true);
  const u32 = (at) => view.getUint32(at, true);
  const nGauges = view.getUint16(16, true);
  const nContacts = view.getUint16(18, true);
  const nOthers = view.getUint16(20, true);
  const flags = view.getUint16(22, true);
  const components = view.getUint8(2);
  const nTruths = view.getUint16(72, true);
  const rangesAt = HEADER_BYTES + 4 * nGauges;
  const statesAt = rangesAt + 8 * nGauges;
  const contactsAt = statesAt + 4 * Math.ceil(nGauges / 4);
  const othersAt = contactsAt + MARK_BYTES * nContacts;
  const truthsAt = othersAt + MARK_BYTES * nOthers;
  const displacementAt = truthsAt + MARK_BYTES * nTruths;
  return {
    seq: u32(4),
    t: view.getFloat64(8, true),
    health: {
      rate: f32(28), lost: u32(32), dropped: u32(64), crc: u32(36), p50: f32(40), p99: f32(44), clock: f32(48),
      recording: ["off", "on", "failed"][view.getUint8(3)], recorded: f32(52),
    },
    replay: Number.isFinite(f32(60)) ? { position: f32(56), duration: f32(60), paused: Boolean(flags & 1) } : null,
    phase: PHASES[(flags >> 4) & 7],
    why: WHY[(flags >> 8) & 7],
    stale: Boolean(flags & 2),
    p: f32(68),
    readings: new Float32Array(buffer, HEADER_BYTES, nGauges),
    ranges: new Float32Array(buffer, rangesAt, 2 * nGauges),
    states: new Uint8Array(buffer, statesAt, nGauges),
    contacts: readMarks(buffer, contactsAt, nContacts),
    others: readMarks(buffer, othersAt, nOthers),
    truths: readMarks(buffer, truthsAt, nTruths),
    components,
    displacement: new Float32Array(buffer, displacementAt, components * u32(24)),
  };
}

/** The same frame in less memory. */
export function withoutDisplacement({ displacement }) {
  const light = displacement.buffer.slice(0, displacement.byteOffset);
  new DataView(light).setUint8(2, 0);
  new DataView(light).setUint32(24, 0, true);
  return readFrame(light);
}

function readMarks(buffer, at, n) {
  return Array.from({ length: n }, (_, i) => {
    const [id] = new Uint32Array(buffer, at + MARK_BYTES * i, 1);
    const w = new Float32Array(buffer, at + MARK_BYTES * i, 20);
    const force = w.subarray(8, 11);
    return {
      id,
      weight: w[1],
      position: w.subarray(2, 5),
      normal: w.subarray(5, 8),
      force,
      newtons: Math.hypot(...force),
      forceSd: w[11],
      range: w.subarray(18, 20),
      axes: Number.isFinite(w[12]) ? [w.subarray(12, 15), w.subarray(15, 18)] : null,
    };
  });
}
