// From the landmark to the picture: the camera model of the calibration, as ROS and OpenCV have it.
export function rotationOf([w, x, y, z]) {
  return [
    [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
    [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
    [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
  ];
}

export const times = (m, v) => m.map((row) => row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
export const transposedTimes = (m, v) => [0, 1, 2].map((i) => m[0][i] * v[0] + m[1][i] * v[1] + m[2][i] * v[2]);

// Where a ray through (x, y, 1) meets the picture's plane, in units of the focal length.
export function distorted(lens, k, x, y) {
  const r2 = x * x + y * y;
  if (lens === 2) {
    const r = Math.sqrt(r2);
    const a = Math.atan(r);
    const a2 = a * a;
    const scale = r < 1e-9 ? 1 : (a * (1 + a2 * (k[0] + a2 * (k[1] + a2 * (k[2] + a2 * k[3]))))) / r;
    return [x * scale, y * scale];
  }
  const above = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  const below = lens === 1 ? 1 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])) : 1;
  const scale = above / below;
  return [
    x * scale + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x),
    y * scale + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y,
  ];
}

// A function from a point of the landmark's frame [mm] to a pixel, or null where it can't be seen.
export function projector(camera, pose) {
  const rotation = rotationOf(pose.q);
  const [fx, fy, cx, cy] = camera.intrinsics;
  return (point) => {
    const p = transposedTimes(rotation, point.map((value, i) => value - pose.mm[i]));
    if (p[2] < 1) return null;
    const [x, y] = distorted(camera.lens, camera.distortion, p[0] / p[2], p[1] / p[2]);
    return [fx * x + cx, fy * y + cy];
  };
}

// The middle of dot 0..8 (P1..P9) in the sheet's plane [mm].
export function dotCentre(camera, dot) {
  if (dot === 8) return [0, 0, 0];
  const angle = (dot * Math.PI) / 4;
  return [camera.ring_mm * Math.sin(angle), 0, -camera.ring_mm * Math.cos(angle)];
}

export function circle([x, , z], radius, count = 48) {
  return Array.from({ length: count + 1 }, (_, i) => {
    const angle = (2 * Math.PI * i) / count;
    return [x + radius * Math.cos(angle), 0, z + radius * Math.sin(angle)];
  });
}
