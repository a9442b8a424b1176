// From the picture back to rays, for every model of a lens: the inverse of projection.js, found by Newton's steps.
import { distorted } from "./projection.js";

// Rays further off the axis than 76 degrees have no place in a flat picture of reasonable size.
const WIDEST = 4;
// Cells of the mesh: between its nodes the lens is taken for linear, which strong ones miss by a few hundredths of a pixel.
const COLUMNS = 80;
const ROWS = 60;
const STEP = 1e-6;
const CLOSE = 1e-9;

// A ray (x, y, 1) near which the search begins. A fisheye's picture is an angle, not a tangent.
function guess(lens, [x, y]) {
  const angle = Math.hypot(x, y);
  if (lens !== 2 || angle < 1e-9) return [x, y];
  const scale = Math.tan(Math.min(angle, Math.atan(WIDEST))) / angle;
  return [x * scale, y * scale];
}

// The ray (x, y, 1) that is seen at the pixel, or null where the lens has none.
export function rayOf({ lens, distortion, intrinsics: [fx, fy, cx, cy] }, u, v) {
  const wanted = [(u - cx) / fx, (v - cy) / fy];
  let [x, y] = guess(lens, wanted);
  for (let i = 0; i < 30; ++i) {
    const at = distorted(lens, distortion, x, y);
    const miss = [wanted[0] - at[0], wanted[1] - at[1]];
    const right = distorted(lens, distortion, x + STEP, y);
    const below = distorted(lens, distortion, x, y + STEP);
    const [a, b, c, d] = [right[0] - at[0], below[0] - at[0], right[1] - at[1], below[1] - at[1]].map((change) => change / STEP);
    const area = a * d - b * c;
    // Beyond a fold the formula goes on, and says nothing of the lens.
    if (!(area > 0) || !(Math.hypot(x, y) <= 2 * WIDEST)) return null;
    if (Math.hypot(...miss) < CLOSE) return Math.hypot(x, y) <= WIDEST ? [x, y] : null;
    x += (d * miss[0] - b * miss[1]) / area;
    y += (a * miss[1] - c * miss[0]) / area;
  }
  return null;
}

// A mesh over the picture. corners: x, y, 0 from -1 to 1 as WebGL has them, y up; rays: x, y and whether there is one;
// window: [least x, least y, greatest x, greatest y] of them all.
export function lensMesh(camera) {
  const corners = [];
  const rays = [];
  const window = [Infinity, Infinity, -Infinity, -Infinity];
  for (let row = 0; row <= ROWS; ++row)
    for (let column = 0; column <= COLUMNS; ++column) {
      const [across, down] = [column / COLUMNS, row / ROWS];
      // Pixel centres are integers: the picture begins half a pixel before the first.
      const ray = rayOf(camera, across * camera.width - 0.5, down * camera.height - 0.5);
      corners.push(2 * across - 1, 1 - 2 * down, 0);
      rays.push(...(ray ?? [0, 0]), ray ? 1 : 0);
      for (const i of ray ? [0, 1] : []) {
        window[i] = Math.min(window[i], ray[i]);
        window[i + 2] = Math.max(window[i + 2], ray[i]);
      }
    }
  const faces = [];
  for (let row = 0; row < ROWS; ++row)
    for (let column = 0; column < COLUMNS; ++column) {
      const first = row * (COLUMNS + 1) + column;
      const next = first + COLUMNS + 1;
      faces.push(first, next, first + 1, first + 1, next, next + 1);
    }
  return { corners, rays, faces, window };
}
