// The picture and a model in it, as the camera would have seen it: the model is drawn as a pinhole camera sees it, and
// that drawing is laid over the picture bent as the lens bends. Lengths in metres; the scene's frame is the landmark's.
import { lensMesh } from "./ar_lens.js";
import { rotationOf, times, transposedTimes } from "./projection.js";

const NEAR_M = 0.02;
const FAR_M = 200;
// The drawing has as many pixels as the picture at its middle, and half as many more where nothing else smooths its edges.
const [FINE, FINER] = [1, 1.5];
// Only that of a fisheye that sees half of all around is coarser.
const MOST_PX = 2048;

const VERTEX = `
attribute vec3 ray;
varying vec3 vRay;
varying vec2 vPicture;
void main() {
  vRay = ray;
  vPicture = vec2(0.5 + 0.5 * position.x, 0.5 - 0.5 * position.y);
  gl_Position = vec4(position.xy, 0.0, 1.0);
}`;

// drawn: colours times their cover, linear, in the part of it that is used; window: least x, least y, 1 / width, 1 / height.
const FRAGMENT = `
uniform sampler2D picture;
uniform sampler2D drawn;
uniform vec4 window;
uniform vec2 used;
uniform float cover;
varying vec3 vRay;
varying vec2 vPicture;
vec3 encoded(vec3 light) {
  return mix(12.92 * light, 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, light));
}
void main() {
  vec3 colour = texture2D(picture, vPicture).rgb;
  vec2 at = (vRay.xy - window.xy) * window.zw;
  if (vRay.z > 0.999 && at == clamp(at, 0.0, 1.0)) {
    vec4 model = texture2D(drawn, used * vec2(at.x, 1.0 - at.y));
    colour = mix(colour, encoded(model.rgb / max(model.a, 0.001)), model.a * cover);
  }
  gl_FragColor = vec4(colour, 1.0);
}`;

// Frees what a model holds of the graphics processor.
function free(object) {
  object.traverse(({ geometry, material }) => {
    geometry?.dispose();
    for (const one of [material].flat().filter(Boolean)) {
      for (const value of Object.values(one)) if (value?.isTexture) value.dispose();
      one.dispose();
    }
  });
}

const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const along = (a, b) => a.map((value, i) => value - dot(a, b) * b[i]);

// The world's up in the landmark's frame; the sheet's own where the landmark has no place in the world.
function upOf(frame) {
  const { q } = frame.in_world;
  if (q.some((value) => value === null) || Math.hypot(...q) < 0.5) return [0, 0, 1];
  return times(rotationOf(frame.in_landmark.q), transposedTimes(rotationOf(q), [0, 0, 1]));
}

// Right, up and front of a model, in the landmark's frame: standing on the sheet, its front towards the lower edge; or
// upright, its front to where the sheet faces.
export function axesOf(stance, frame) {
  if (stance === "sheet") return [[-1, 0, 0], [0, 1, 0], [0, 0, -1]];
  const up = upOf(frame);
  const level = along([0, 1, 0], up);
  const front = Math.hypot(...level) > 0.2 ? level : along([0, 0, -1], up);
  const length = Math.hypot(...front);
  const unit = front.map((value) => value / length);
  return [cross(up, unit), up, unit];
}

export class ArScene {
  // Throws where the browser can't do it: one line that says so.
  constructor(three, canvas) {
    const context = canvas.getContext("webgl2", { alpha: false, antialias: false, depth: false });
    if (!context) throw new Error("This browser draws nothing in three dimensions (no WebGL 2): allow it hardware acceleration, or use another one.");
    Object.assign(this, { three, canvas, context });
    this.renderer = new three.WebGLRenderer({ canvas, context });
    this.renderer.setClearColor(0, 0);
    const name = context.getExtension("WEBGL_debug_renderer_info");
    this.isSoftware = /swiftshader|llvmpipe|software/i.test(name ? context.getParameter(name.UNMASKED_RENDERER_WEBGL) : "");
    this.picture = Object.assign(new three.Texture(), { flipY: false, generateMipmaps: false, minFilter: three.LinearFilter, colorSpace: three.NoColorSpace });
    // Smooth edges would cost a processor twice as much as all the rest.
    this.target = new three.WebGLRenderTarget(1, 1, { samples: this.isSoftware ? 0 : 4, colorSpace: three.SRGBColorSpace });
    this.target.scissorTest = true;
    this.camera = Object.assign(new three.PerspectiveCamera(), { matrixAutoUpdate: false });
    this.flat = new three.Scene();
    this.scene = new three.Scene();
    this.standing = Object.assign(new three.Group(), { matrixAutoUpdate: false });
    const sun = new three.DirectionalLight(0xffffff, 2);
    sun.position.set(-1, 2, 1.5);
    this.scene.add(new three.HemisphereLight(0xffffff, 0x808890, 1.6), sun, this.standing);
    this.material = new three.ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, depthTest: false, depthWrite: false,
      uniforms: { picture: { value: this.picture }, drawn: { value: this.target.texture }, window: { value: [0, 0, 1, 1] }, used: { value: [1, 1] }, cover: { value: 0 } } });
  }

  setModel(object) {
    if (this.model) {
      this.standing.remove(this.model);
      free(this.model);
    }
    this.model = object;
    this.box = new this.three.Box3().setFromObject(object);  // its own: before it stands anywhere
    this.standing.add(object);
    return this.box;
  }

  setLens(camera) {
    const lens = JSON.stringify([camera.lens, camera.width, camera.height, camera.intrinsics, camera.distortion]);
    if (lens === this.lens) return;
    this.lens = lens;
    const { three } = this;
    const { corners, rays, faces, window } = lensMesh(camera);
    this.mesh?.geometry.dispose();
    this.flat.clear();
    const geometry = new three.BufferGeometry();
    geometry.setAttribute("position", new three.BufferAttribute(new Float32Array(corners), 3));
    geometry.setAttribute("ray", new three.BufferAttribute(new Float32Array(rays), 3));
    geometry.setIndex(faces);
    this.mesh = Object.assign(new three.Mesh(geometry, this.material), { frustumCulled: false });
    this.flat.add(this.mesh);
    this.window = window;
  }

  // place: {stance, isTrueSize, size_mm of the longest side, turn_deg about up, raise_mm}
  stand(frame, { stance, isTrueSize, size_mm: size, turn_deg: turn, raise_mm: raise }) {
    const { three, box } = this;
    const [right, up, front] = axesOf(stance, frame);
    const extent = box.getSize(new three.Vector3());
    const scale = isTrueSize ? 1 : size / 1000 / Math.max(extent.x, extent.y, extent.z, 1e-9);
    const middle = box.getCenter(new three.Vector3());
    const foot = isTrueSize ? new three.Vector3() : new three.Vector3(middle.x, box.min.y, middle.z);
    // Before a sheet that it stands upright at, not in it.
    const ahead = stance === "upright" && !isTrueSize ? (scale * Math.max(extent.x, extent.z)) / 2 : 0;
    const at = up.map((value, i) => (value * raise) / 1000 + front[i] * ahead);
    this.standing.matrix.makeBasis(...[right, up, front].map((axis) => new three.Vector3(...axis))).setPosition(...at)
      .multiply(new three.Matrix4().makeRotationY((turn * Math.PI) / 180)).multiply(new three.Matrix4().makeScale(scale, scale, scale))
      .multiply(new three.Matrix4().makeTranslation(-foot.x, -foot.y, -foot.z));
    this.standing.updateMatrixWorld(true);
  }

  // WebGL's camera looks along -z with y up, ours along z with y down.
  look(pose) {
    const r = rotationOf(pose.q);
    const [x, y, z] = pose.mm.map((value) => value / 1000);
    this.camera.matrix.set(r[0][0], -r[0][1], -r[0][2], x, r[1][0], -r[1][1], -r[1][2], y, r[2][0], -r[2][1], -r[2][2], z, 0, 0, 0, 1);
    this.camera.updateMatrixWorld(true);
  }

  // The part of the pinhole's plane that the model is in, so that the drawing is as fine as the picture whatever the lens;
  // null: the model is nowhere in sight.
  windowOf(camera) {
    const [x0, y0, x1, y1] = this.window;
    const corner = new this.three.Vector3();
    const seen = [x1, y1, x0, y0];
    for (let i = 0; i < 8; ++i) {
      corner.set(...["x", "y", "z"].map((axis, bit) => this.box[i >> bit & 1 ? "max" : "min"][axis]));
      corner.applyMatrix4(this.standing.matrixWorld).applyMatrix4(this.camera.matrixWorldInverse);
      if (-corner.z < NEAR_M) return [...this.window];
      const ray = [corner.x / -corner.z, corner.y / corner.z];
      for (const n of [0, 1]) {
        seen[n] = Math.min(seen[n], ray[n]);
        seen[n + 2] = Math.max(seen[n + 2], ray[n]);
      }
    }
    const window = [Math.max(x0, seen[0]), Math.max(y0, seen[1]), Math.min(x1, seen[2]), Math.min(y1, seen[3])];
    if (window[0] >= window[2] || window[1] >= window[3]) return null;
    for (const n of [0, 1]) {
      window[n] -= 2 / camera.intrinsics[n];
      window[n + 2] += 2 / camera.intrinsics[n];
    }
    return window;
  }

  // Draws one frame: its picture, and the model (if any is to be seen) by its own pose.
  draw(bitmap, camera, frame, place) {
    const { renderer, canvas, picture, target, material: { uniforms } } = this;
    this.setLens(camera);
    const ratio = window.devicePixelRatio || 1;
    const scale = this.isSoftware ? 1 : Math.min(2, Math.max(1, (canvas.clientWidth * ratio) / camera.width));
    const [width, height] = [camera.width, camera.height].map((size) => Math.round(size * scale));
    if (canvas.width !== width || canvas.height !== height) renderer.setSize(width, height, false);
    this.pixels = [0, 1].map((n) => scale * (this.isSoftware ? FINER : FINE) * camera.intrinsics[n]);
    const room = this.pixels.map((pixels, n) => Math.min(MOST_PX, Math.ceil(pixels * (this.window[n + 2] - this.window[n])) + 8));
    if (target.width !== room[0] || target.height !== room[1]) target.setSize(...room);
    if (picture.image !== bitmap) {
      if (picture.image && (picture.image.width !== bitmap.width || picture.image.height !== bitmap.height)) picture.dispose();
      Object.assign(picture, { image: bitmap, needsUpdate: true });
    }
    uniforms.cover.value = place && this.model && this.drawModel(camera, frame, place) ? 1 : 0;
    renderer.setRenderTarget(null);
    renderer.render(this.flat, this.camera);
  }

  drawModel(camera, frame, place) {
    this.stand(frame, place);
    this.look(frame.in_landmark);
    const window = this.windowOf(camera);
    if (!window) return false;
    const [x0, y0, x1, y1] = window;
    this.camera.projectionMatrix.makePerspective(x0 * NEAR_M, x1 * NEAR_M, -y0 * NEAR_M, -y1 * NEAR_M, NEAR_M, FAR_M);
    this.camera.projectionMatrixInverse.copy(this.camera.projectionMatrix).invert();
    this.material.uniforms.window.value = [x0, y0, 1 / (x1 - x0), 1 / (y1 - y0)];
    const room = [this.target.width, this.target.height];
    const used = this.pixels.map((pixels, n) => Math.max(1, Math.min(room[n], Math.round(pixels * (window[n + 2] - window[n])))));
    this.material.uniforms.used.value = used.map((pixels, n) => pixels / room[n]);
    this.target.viewport.set(0, 0, ...used);
    this.target.scissor.set(0, 0, ...used);
    this.renderer.setRenderTarget(this.target);
    this.renderer.clear();
    this.renderer.render(this.scene, this.camera);
    this.triangles = this.renderer.info.render.triangles;
    return true;
  }

  // Gives back all of it, the context too: a browser has sixteen.
  dispose() {
    if (this.model) free(this.model);
    this.mesh?.geometry.dispose();
    for (const one of [this.material, this.picture, this.target, this.renderer]) one.dispose();
    this.renderer.forceContextLoss();
  }
}
