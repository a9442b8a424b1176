// Recordings of the landmark through lenses of any kind, drawn here, and models for it: with formulas of their own, so
// that a mistake of the page's or of the service's shows. Lengths in mm, the landmark's frame.
import fs from "node:fs";
import path from "node:path";

const RING_MM = 80;
const DOT_MM = 12.7;
const CENTRE_MM = 25.4;
const SHEET_MM = 105;
const [WALL, PAPER, INK] = [120, 220, 25];
// Rows within a pixel's row.
const FINE = 8;

export const DOTS = Array.from({ length: 8 }, (_, i) => [RING_MM * Math.sin((i * Math.PI) / 4), 0, -RING_MM * Math.cos((i * Math.PI) / 4)]).concat([[0, 0, 0]]);
export const radiusOf = (dot) => (dot === 8 ? CENTRE_MM : DOT_MM);

const minus = (a, b) => a.map((value, i) => value - b[i]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((value) => value / Math.hypot(...a));

// A camera at `mm` that looks at `at`, upright.
export function looking(mm, at) {
  const ahead = unit(minus(at, mm));
  const right = unit(cross(ahead, [0, 0, 1]));
  return { mm, axes: [right, cross(ahead, right), ahead] };
}

// Of a row of truth.csv.
function poseOf([x, y, z, qw, qx, qy, qz]) {
  const turned = ([vx, vy, vz]) => {
    const t = cross([qx, qy, qz], [vx, vy, vz]).map((value) => 2 * value);
    const u = cross([qx, qy, qz], t);
    return [vx, vy, vz].map((value, i) => value + qw * t[i] + u[i]);
  };
  return { mm: [x, y, z], axes: [turned([1, 0, 0]), turned([0, 1, 0]), turned([0, 0, 1])] };
}

export function truthOf(folder) {
  return fs.readFileSync(path.join(folder, "truth.csv"), "utf8").trim().split("\n").slice(1).map((line) => line.split(",")).filter((row) => row[2] === "1")
    .map((row) => poseOf(row.slice(4, 11).map(Number)));
}

// lens: {model, k, f, width, height}, as camera.yaml has them. Where the point is in the picture; pixel centres at integers.
export function pixelOf({ model, k, f, width, height }, { mm, axes }, point) {
  const [px, py, pz] = axes.map((axis) => dot(axis, minus(point, mm)));
  let [x, y] = [px / pz, py / pz];
  if (model === "equidistant") {
    const sine = Math.hypot(px, py);
    const angle = Math.atan2(sine, pz);
    const bent = angle + k[0] * angle ** 3 + k[1] * angle ** 5 + k[2] * angle ** 7 + k[3] * angle ** 9;
    [x, y] = sine < 1e-9 ? [0, 0] : [(bent * px) / sine, (bent * py) / sine];
  } else {
    const [k1, k2, p1, p2, k3, k4 = 0, k5 = 0, k6 = 0] = k;
    const r2 = x * x + y * y;
    const radial = (1 + k1 * r2 + k2 * r2 ** 2 + k3 * r2 ** 3) / (1 + k4 * r2 + k5 * r2 ** 2 + k6 * r2 ** 3);
    [x, y] = [x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y];
  }
  return [f * x + (width - 1) / 2, f * y + (height - 1) / 2];
}

// How much of each pixel a closed line covers, added to `cover`.
function fill(cover, width, height, outline) {
  const rows = outline.map(([, v]) => v);
  for (let line = Math.max(0, Math.floor((Math.min(...rows) + 0.5) * FINE)); line < Math.min(height * FINE, (Math.max(...rows) + 0.5) * FINE); ++line) {
    const v = (line + 0.5) / FINE - 0.5;
    const cuts = [];
    outline.forEach(([u1, v1], i) => {
      const [u2, v2] = outline[(i + 1) % outline.length];
      if ((v1 <= v) !== (v2 <= v)) cuts.push(u1 + ((v - v1) * (u2 - u1)) / (v2 - v1));
    });
    cuts.sort((a, b) => a - b);
    for (let i = 0; i + 1 < cuts.length; i += 2)
      for (let u = Math.max(0, Math.floor(cuts[i] + 0.5)); u <= Math.min(width - 1, Math.floor(cuts[i + 1] + 0.5)); ++u)
        cover[Math.floor(line / FINE) * width + u] += Math.max(0, Math.min(u + 0.5, cuts[i + 1]) - Math.max(u - 0.5, cuts[i])) / FINE;
  }
}

function drawn(lens, pose, lacks) {
  const { width, height } = lens;
  const [sheet, ink] = [new Float64Array(width * height), new Float64Array(width * height)];
  const side = Array.from({ length: 100 }, (_, i) => (2 * SHEET_MM * i) / 100 - SHEET_MM);
  const edge = [...side.map((s) => [s, -SHEET_MM]), ...side.map((s) => [SHEET_MM, s]), ...side.map((s) => [-s, SHEET_MM]), ...side.map((s) => [-SHEET_MM, -s])];
  fill(sheet, width, height, edge.map(([x, z]) => pixelOf(lens, pose, [x, 0, z])));
  DOTS.forEach(([x, , z], i) => {
    if (i === lacks) return;
    const around = Array.from({ length: 120 }, (_, n) => [x + radiusOf(i) * Math.cos((n * Math.PI) / 60), 0, z + radiusOf(i) * Math.sin((n * Math.PI) / 60)]);
    fill(ink, width, height, around.map((point) => pixelOf(lens, pose, point)));
  });
  let noise = 12345;
  return Uint8Array.from(sheet, (cover, i) => {
    noise = (Math.imul(noise, 1103515245) + 12345) >>> 0;
    return Math.round(WALL + (PAPER - WALL) * cover - (PAPER - INK) * ink[i] + ((noise >>> 16) / 65536 - 0.5) * 5);
  });
}

// A recording in `folder`, a frame for each pose. lacks: a dot that the sheet does not have
export function drawRecording(folder, lens, poses, { lacks } = {}) {
  fs.mkdirSync(path.join(folder, "frames"), { recursive: true });
  poses.forEach((pose, i) => fs.writeFileSync(path.join(folder, "frames", `${String(i).padStart(6, "0")}.pgm`), Buffer.concat([Buffer.from(`P5\n${lens.width} ${lens.height}\n255\n`), drawn(lens, pose, lacks)])));
  fs.writeFileSync(path.join(folder, "camera.yaml"), `image_width: ${lens.width}\nimage_height: ${lens.height}\ncamera_name: drawn
camera_matrix:\n  rows: 3\n  cols: 3\n  data: [${lens.f}, 0, ${(lens.width - 1) / 2}, 0, ${lens.f}, ${(lens.height - 1) / 2}, 0, 0, 1]
distortion_model: ${lens.model}\ndistortion_coefficients:\n  rows: 1\n  cols: ${lens.k.length}\n  data: [${lens.k.join(", ")}]\n`);
}

const boundsOf = (numbers) => ({ min: [0, 1, 2].map((axis) => Math.min(...numbers.filter((_, i) => i % 3 === axis))), max: [0, 1, 2].map((axis) => Math.max(...numbers.filter((_, i) => i % 3 === axis))) });

// A .gltf of discs parallel to the sheet: [{at: mm in the landmark's frame, radius, colour}]; more: into the JSON.
// Standing on the sheet in its true size, a model's x and z are the landmark's, turned half about y.
export function discsGltf(discs, more = {}) {
  const sides = 48;
  const places = discs.flatMap(({ at: [x, y, z], radius }) => Array.from({ length: sides }, (_, i) => [[x, y, z],
    ...[i, i + 1].map((step) => [x + radius * Math.cos((2 * Math.PI * step) / sides), y, z + radius * Math.sin((2 * Math.PI * step) / sides)])]).flat());
  const numbers = Float32Array.from(places.flatMap(([x, y, z]) => [-x / 1000, y / 1000, -z / 1000]));
  const one = 3 * sides;
  return JSON.stringify({
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }], extensionsUsed: ["KHR_materials_unlit"],
    meshes: [{ primitives: discs.map((_, i) => ({ attributes: { POSITION: i, ...(more.images ? { TEXCOORD_0: i + discs.length } : {}) }, material: i })) }],
    materials: discs.map(({ colour }) => ({ doubleSided: true, extensions: { KHR_materials_unlit: {} }, pbrMetallicRoughness: more.images ? { baseColorTexture: { index: 0 } } : { baseColorFactor: [...colour, 1] } })),
    accessors: [...discs.map((_, i) => ({ bufferView: 0, byteOffset: 12 * one * i, componentType: 5126, count: one, type: "VEC3", ...boundsOf(numbers.subarray(3 * one * i, 3 * one * (i + 1))) })),
      ...(more.images ? discs.map((_, i) => ({ bufferView: 0, byteOffset: 12 * one * i, componentType: 5126, count: one, type: "VEC2" })) : [])],
    bufferViews: [{ buffer: 0, byteLength: numbers.byteLength }],
    buffers: [{ byteLength: numbers.byteLength, uri: `data:application/octet-stream;base64,${Buffer.from(numbers.buffer).toString("base64")}` }], ...more,
  });
}
