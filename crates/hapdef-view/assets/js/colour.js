// Colours: viridis and cividis (matplotlib, CC0), and the contacts' own.

import { Color, SRGBColorSpace } from "../vendor/three/three.module.min.js";

const MAPS = {
  viridis:
    "440154470d6048186a482374472d7b4537814240863e49893b528b375b8d33638d2f6b8e2c728e297a8e26828e23898e21918c1f978b1f9f8821a68527ad8131b57b3dbc744cc26c5cc8636ece5881d34d95d840aadc32c0df25d5e21aeae51afde725",
  cividis:
    "00224e00285b002e6a0533711a386f273e6e32436d3b496c434e6c4b546c535a6d5a5f6e61656f686a716f70737676767d7c788381798b8778928d789a9376a29975aaa073b3a670bbad6dc3b369ccba64d4c15fddc858e6d051efd748f8df3cfee838",
};

/** Colour-blind safe (Okabe and Ito), apart from the maps' colours. */
const CONTACTS = ["#ff7a33", "#4fb3ff", "#ff5fa2", "#ffd24d", "#b18cff", "#ff4d4d"];

/** The colour of a contact. */
export const contactColour = (id) => CONTACTS[id % CONTACTS.length];

/** A map's colour at `x` in 0…1, as [r, g, b] of sRGB in 0…1. */
export function mapColour(name, x) {
  const hex = MAPS[name];
  const n = hex.length / 6 - 1;
  const at = Math.min(Math.max(x, 0), 1) * n;
  const i = Math.min(Math.floor(at), n - 1);
  const part = (k, c) => parseInt(hex.slice(6 * k + 2 * c, 6 * k + 2 * c + 2), 16) / 255;
  return [0, 1, 2].map((c) => part(i, c) + (at - i) * (part(i + 1, c) - part(i, c)));
}

/** A map as 256 linear colours, for vertices. */
export function mapTable(name) {
  const table = new Float32Array(3 * 256);
  const colour = new Color();
  for (let i = 0; i < 256; i += 1) {
    colour.setRGB(...mapColour(name, i / 255), SRGBColorSpace).toArray(table, 3 * i);
  }
  return table;
}

/** A number in 1, 2, 5 · 10ⁿ, or in other steps, not below `x`. */
export function roundUp(x, steps = [1, 2, 5, 10]) {
  if (!(x > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(x));
  return power * steps.find((step) => step * power >= x * 0.999999);
}
