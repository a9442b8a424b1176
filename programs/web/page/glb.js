// glTF files, checked before anything else reads them, and made into one block: JSON and bytes, nothing beside it. So
// nothing is ever fetched for a model, and the page's content policy stays as it is.
export const MOST_MB = 32;
// Of all lists of numbers in a model together: a small file may claim many.
const MOST_NUMBERS = 6e6;
const MAGIC = 0x46546c67;
const JSON_CHUNK = 0x4e4f534a;
const BIN_CHUNK = 0x004e4942;
const PICTURES = ["image/png", "image/jpeg", "image/webp"];
const KNOWN = /^(KHR_materials_\w+|KHR_texture_transform|KHR_mesh_quantization|KHR_lights_punctual|EXT_texture_webp)$/;

const refuse = (text) => { throw new Error(text); };
const whole = (bytes) => (bytes + 3) & ~3;

export function packGlb(json, bytes) {
  const text = new TextEncoder().encode(JSON.stringify(json));
  const [textBytes, binBytes] = [whole(text.length), whole(bytes.length)];
  const file = new Uint8Array(12 + 8 + textBytes + 8 + binBytes).fill(0x20, 20, 20 + textBytes);
  const view = new DataView(file.buffer);
  [MAGIC, 2, file.length, textBytes, JSON_CHUNK].forEach((word, i) => view.setUint32(4 * i, word, true));
  file.set(text, 20);
  view.setUint32(20 + textBytes, binBytes, true);
  view.setUint32(24 + textBytes, BIN_CHUNK, true);
  file.set(bytes, 28 + textBytes);
  return file.buffer;
}

function unpackGlb(file) {
  const view = new DataView(file.buffer, file.byteOffset, file.length);
  if (view.getUint32(4, true) !== 2) refuse("it is glTF of another version: export it as glTF 2.0");
  if (view.getUint32(8, true) > file.length) refuse("it is cut short: copy it again");
  let json = null;
  let bytes = null;
  for (let at = 12; at + 8 <= file.length;) {
    const [length, kind] = [view.getUint32(at, true), view.getUint32(at + 4, true)];
    if (length > file.length - at - 8) refuse("it is cut short: copy it again");
    const chunk = file.subarray(at + 8, at + 8 + length);
    if (kind === JSON_CHUNK) json ??= chunk;
    if (kind === BIN_CHUNK) bytes ??= chunk;
    at += 8 + length;
  }
  return { text: json ?? refuse("it has no description of a scene: export it again"), bytes };
}

function embedded(uri, what) {
  const match = /^data:([^;,]*)(?:;[^,;]*)*;base64,(.*)$/s.exec(uri);
  if (!match) refuse(`${what} is in another file, ${uri.slice(0, 40)}: export it as one .glb`);
  try {
    return { type: match[1], bytes: Uint8Array.from(atob(match[2]), (letter) => letter.charCodeAt(0)) };
  } catch {
    return refuse(`${what} can't be read: export it as one .glb`);
  }
}

// All buffers one after the other, and the pictures behind them.
function gather(json, bin) {
  const parts = [];
  let length = 0;
  const add = (bytes) => {
    const at = length;
    parts.push([at, bytes]);
    length += whole(bytes.length);
    return at;
  };
  const starts = (json.buffers ?? []).map((buffer, i) => add(buffer.uri === undefined ? (i === 0 && bin) || refuse("a part of it is missing: export it as one .glb") : embedded(buffer.uri, "a part of it").bytes));
  const views = (json.bufferViews ?? []).map((view) => ({ ...view, buffer: 0, byteOffset: (view.byteOffset ?? 0) + (starts[view.buffer] ?? refuse("a part of it is missing: export it again")) }));
  const images = (json.images ?? []).map(({ uri, ...image }) => {
    if (uri !== undefined) {
      const { type, bytes } = embedded(uri, "a texture of it");
      views.push({ buffer: 0, byteOffset: add(bytes), byteLength: bytes.length });
      Object.assign(image, { mimeType: type, bufferView: views.length - 1 });
    }
    if (!PICTURES.includes(image.mimeType)) refuse(`a texture of it is ${image.mimeType}: PNG, JPEG and WebP can be shown`);
    return image;
  });
  const all = new Uint8Array(length);
  for (const [at, bytes] of parts) all.set(bytes, at);
  if (views.some((view) => view.byteOffset + view.byteLength > length)) refuse("a part of it is missing: export it again");
  return { json: { ...json, buffers: [{ byteLength: length }], bufferViews: views, ...(images.length ? { images } : {}) }, all };
}

function check(json) {
  if (!/^2\./.test(json?.asset?.version ?? "")) refuse("it is no glTF 2.0 file: export it as .glb");
  const unknown = (json.extensionsRequired ?? []).find((name) => !KNOWN.test(name));
  if (unknown) refuse(`it needs ${unknown}, which is not read here: export it without compression`);
  const sizes = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT2: 4, MAT3: 9, MAT4: 16 };
  const numbers = (json.accessors ?? []).reduce((sum, accessor) => sum + accessor.count * sizes[accessor.type], 0);
  if (!(numbers <= MOST_NUMBERS)) refuse("it is too detailed for a page: reduce it below 500,000 triangles");
  if (!json.meshes?.length) refuse("there is nothing in it to be seen: export it with its meshes");
}

// bytes of a .glb or .gltf file -> a .glb that needs nothing beside it. Throws an Error whose text ends a sentence on the file.
export function readModel(bytes) {
  if (bytes.length > MOST_MB * 1e6) refuse(`it is larger than ${MOST_MB} MB: reduce its detail or its textures`);
  const isBinary = bytes.length >= 20 && new DataView(bytes.buffer, bytes.byteOffset).getUint32(0, true) === MAGIC;
  const { text, bytes: bin } = isBinary ? unpackGlb(bytes) : { text: bytes, bytes: null };
  let json;
  try {
    json = JSON.parse(new TextDecoder().decode(text));
  } catch {
    refuse("it is no glTF 2.0 file: export it as .glb");
  }
  check(json);
  const { json: one, all } = gather(json, bin);
  return packGlb(one, all);
}
