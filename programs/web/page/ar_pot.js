// The model that is there from the start: a fluted pot, as a .glb of any number of triangles. Its wall is a closed line
// that is turned about the axis, so that no triangle is wasted on a tip. 1 m high; one flute, at its front, is red.
import { packGlb } from "./glb.js";

const FLUTES = 12;
// Radius and height, from the foot's inner edge along the outside to the lip, and along the inside back.
const WALL = [[0.06, 0], [0.24, 0], [0.26, 0.03], [0.2, 0.08], [0.27, 0.2], [0.38, 0.38], [0.4, 0.55], [0.33, 0.74], [0.24, 0.86], [0.24, 0.93], [0.31, 1],
  [0.29, 0.98], [0.21, 0.9], [0.22, 0.84], [0.3, 0.7], [0.36, 0.54], [0.33, 0.4], [0.22, 0.22], [0.06, 0.12]];

// A smooth closed line through the wall's points (Catmull and Rom's), s from 0 to 1.
function wallAt(s) {
  const at = s * WALL.length;
  const i = Math.floor(at);
  const t = at - i;
  const [a, b, c, d] = [-1, 0, 1, 2].map((k) => WALL[(i + k + WALL.length) % WALL.length]);
  return [0, 1].map((n) => b[n] + 0.5 * t * (c[n] - a[n] + t * (2 * a[n] - 5 * b[n] + 4 * c[n] - d[n] + t * (3 * (b[n] - c[n]) + d[n] - a[n]))));
}

function pointAt(s, turn) {
  const [radius, height] = wallAt(s);
  const isOutside = s > 0.12 && s < 0.5;
  const fluted = radius * (1 + (isOutside ? 0.04 * Math.sin((Math.PI * (s - 0.12)) / 0.38) * Math.cos(FLUTES * turn) : 0));
  return [fluted * Math.sin(turn), height, fluted * Math.cos(turn)];
}

function normalAt(s, turn) {
  const step = 1e-3;
  const slope = (from, to) => from.map((value, i) => to[i] - value);
  const along = slope(pointAt((s + 1 - step) % 1, turn), pointAt((s + step) % 1, turn));
  const around = slope(pointAt(s, turn - step), pointAt(s, turn + step));
  const normal = [around[1] * along[2] - around[2] * along[1], around[2] * along[0] - around[0] * along[2], around[0] * along[1] - around[1] * along[0]];
  const length = Math.hypot(...normal) || 1;
  return normal.map((value) => value / length);
}

function colourAt(s, turn) {
  const isFront = Math.abs(Math.atan2(Math.sin(turn), Math.cos(turn))) < Math.PI / FLUTES;
  if (s > 0.12 && s < 0.5 && isFront) return [0.75, 0.06, 0.04];
  return s > 0.5 ? [0.35, 0.3, 0.22] : [0.05 + 0.25 * s, 0.28 + 0.4 * s, 0.4];
}

// around x along cells of two triangles each.
export function potGlb(around, along) {
  const count = (around + 1) * (along + 1);
  const numbers = new Float32Array(9 * count);
  const faces = new Uint32Array(6 * around * along);
  let vertex = 0;
  let face = 0;
  for (let j = 0; j <= along; ++j)
    for (let i = 0; i <= around; ++i) {
      const [s, turn] = [(j % along) / along, (2 * Math.PI * i) / around];
      [pointAt, normalAt, colourAt].forEach((of, part) => numbers.set(of(s, turn), 3 * (part * count + vertex)));
      ++vertex;
      if (i === around || j === along) continue;
      const [here, above] = [j * (around + 1) + i, (j + 1) * (around + 1) + i];
      faces.set([here, here + 1, above, here + 1, above + 1, above], face);
      face += 6;
    }
  const bytes = new Uint8Array(numbers.byteLength + faces.byteLength);
  bytes.set(new Uint8Array(numbers.buffer));
  bytes.set(new Uint8Array(faces.buffer), numbers.byteLength);
  const heights = WALL.map(([, height]) => height);
  const list = (bufferView, more = {}) => ({ bufferView, componentType: 5126, count, type: "VEC3", ...more });
  return packGlb({
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, NORMAL: 1, COLOR_0: 2 }, indices: 3, material: 0 }] }],
    materials: [{ pbrMetallicRoughness: { metallicFactor: 0, roughnessFactor: 0.55 } }],
    accessors: [list(0, { min: [-0.45, Math.min(...heights), -0.45], max: [0.45, Math.max(...heights), 0.45] }), list(1), list(2), { bufferView: 3, componentType: 5125, count: faces.length, type: "SCALAR" }],
    bufferViews: [0, 1, 2].map((part) => ({ buffer: 0, byteOffset: 12 * count * part, byteLength: 12 * count })).concat({ buffer: 0, byteOffset: numbers.byteLength, byteLength: faces.byteLength }),
    buffers: [{ byteLength: bytes.length }],
  }, bytes);
}
