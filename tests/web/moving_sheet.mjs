// A simulated camera that sees a sheet as somebody holds it who calibrates: everywhere in the picture, near, tilted to
// both sides, still for a moment each time. The sheet hangs, and the camera goes round it.
export const WIDTH = 640, HEIGHT = 480;
const FOCAL_PX = 720;  // of a simulated camera without a calibration
// A hand takes longer; the wizard's own search is what has to keep up.
const STILL_S = 0.8, MOVE_S = 0.25;

// {u, v: where the sheet is seen from the middle, -1 to 1; distance_mm; side_deg: from where it is looked at}
function views() {
  const all = [];
  for (const [distance_mm, out] of [[640, 0.52], [520, 0.4], [760, 0.62]])
    for (const side_deg of [0, 36, -36])
      for (const v of [-1, 0, 1])
        for (const u of side_deg ? [-side_deg / 36, 0.5 * side_deg / 36] : [-1, 0, 1]) all.push({ u: u * out, v: v * (out - 0.04), distance_mm, side_deg });
  return all;
}

function standpoint({ u, v, distance_mm, side_deg }) {
  const side = (side_deg * Math.PI) / 180;
  const turn = (Math.atan((u * WIDTH) / 2 / FOCAL_PX) * 180) / Math.PI;
  return {
    x: distance_mm * Math.sin(side), y: distance_mm * Math.cos(side),
    z: (distance_mm * v * HEIGHT) / 2 / FOCAL_PX,
    heading: -90 - side_deg + turn,
  };
}

// The configuration's text: [camera] and [simulation].
export function movingSheet() {
  const points = [];
  let at = 0;
  for (const view of views()) {
    const { x, y, z, heading } = standpoint(view);
    for (const t of [at, at + STILL_S])
      points.push(`[[simulation.robot]]\nt_s = ${t.toFixed(2)}\nx_mm = ${x.toFixed(1)}\ny_mm = ${y.toFixed(1)}\nz_mm = ${z.toFixed(1)}\nheading_deg = ${heading.toFixed(2)}\n`);
    at += STILL_S + MOVE_S;
  }
  return {
    camera: `source = "simulated"\nwidth_px = ${WIDTH}\nheight_px = ${HEIGHT}\nrate_hz = 30`,
    simulation: `[simulation]\nduration_s = ${at.toFixed(2)}\ncamera_delay_ms = 20.0\n${points.join("")}`,
  };
}
