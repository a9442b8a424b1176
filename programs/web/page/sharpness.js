// How sharp the outlines of a landmark's dots are in a picture, and whether paper and ink lie within its range.
const RAYS = 32;
const STEP_PX = 0.25;
const REACH_PX = 6;
// Smaller dots have no middle that the blur of their edge leaves dark.
export const SMALLEST_RADIUS_PX = 3;
// Across an edge: less is shadow, noise, or no edge.
const LEAST_CONTRAST = 20;
// From 20 to 80 % of the step: 2 x 0.8416 sigma of a Gaussian.
const WIDTH_SIGMAS = 1.6832;
// What linear interpolation between pixels adds to the variance, on average over its phase.
const INTERPOLATION_PX2 = 1 / 6;
// An edge's normal within 32 degrees of an axis counts for it.
const ALONG = 0.85;

// {width, height, values}: grey levels 0..255 of an ImageData, as JPEG weighs colours.
export function greyOf({ width, height, data }) {
  const values = new Uint8Array(width * height);
  for (let i = 0, p = 0; i < values.length; ++i, p += 4) values[i] = (77 * data[p] + 150 * data[p + 1] + 29 * data[p + 2]) >> 8;
  return { width, height, values };
}

function levelAt({ width, height, values }, x, y) {
  const left = Math.floor(x);
  const top = Math.floor(y);
  if (left < 0 || top < 0 || left + 1 >= width || top + 1 >= height) return NaN;
  const [a, b] = [x - left, y - top];
  const i = top * width + left;
  return (1 - b) * ((1 - a) * values[i] + a * values[i + 1]) + b * ((1 - a) * values[i + width] + a * values[i + width + 1]);
}

const mean = (list) => list.reduce((sum, value) => sum + value, 0) / list.length;
export const median = (list) => (list.length ? [...list].sort((a, b) => a - b)[list.length >> 1] : NaN);

// Many profiles of one edge, laid over each other at their middles.
class Edge {
  constructor() {
    this.sums = new Map();
    this.count = 0;
  }

  add(levels, middle) {
    ++this.count;
    levels.forEach((level, i) => {
      const bin = Math.round((i - middle) * 2);
      const sum = this.sums.get(bin) ?? [0, 0];
      this.sums.set(bin, [sum[0] + level, sum[1] + 1]);
    });
  }

  // 1-sigma of the blur [px]; NaN: too few profiles.
  sigma() {
    if (this.count < RAYS / 4) return NaN;
    const points = [...this.sums].sort(([a], [b]) => a - b).map(([bin, [sum, count]]) => [(bin / 2) * STEP_PX, sum / count]);
    const crossing = (level) => {
      for (let i = 1; i < points.length; ++i) {
        const [[x0, y0], [x1, y1]] = [points[i - 1], points[i]];
        if (y0 <= level && y1 > level) return x0 + ((level - y0) / (y1 - y0)) * (x1 - x0);
      }
      return NaN;
    };
    const width = (crossing(0.8) - crossing(0.2)) / WIDTH_SIGMAS;
    return Math.sqrt(Math.max(0, width * width - INTERPOLATION_PX2));
  }
}

// One edge from ink to paper, from the inside out; null: there is none.
function profileOf(picture, x, y, nx, ny, reach) {
  const count = 2 * Math.round(reach / STEP_PX) + 1;
  const levels = Array.from({ length: count }, (_, i) => levelAt(picture, x + (i * STEP_PX - reach) * nx, y + (i * STEP_PX - reach) * ny));
  const quarter = Math.floor(count / 4);
  const ink = mean(levels.slice(0, quarter));
  const paper = mean(levels.slice(-quarter));
  if (!(paper - ink >= LEAST_CONTRAST)) return null;
  const relative = levels.map((level) => (level - ink) / (paper - ink));
  const above = relative.findIndex((level, i) => i > 0 && level > 0.5 && relative[i - 1] <= 0.5);
  if (above < 0) return null;
  const middle = above - (relative[above] - 0.5) / (relative[above] - relative[above - 1]);
  return { relative, middle, ink, paper };
}

// dots: [u, v, semi-major, semi-minor, angle in degrees, visible share], as the tap has them.
// null: no dot is large enough, or none has an edge. Blur in px, 1-sigma: of all edges, of upright ones, of level ones.
export function sharpnessOf(picture, dots) {
  const edges = { all: new Edge(), sideways: new Edge(), upright: new Edge() };
  const [inks, papers] = [[], []];
  for (const [u, v, major, minor, angle, visible] of dots) {
    if (!visible || minor < SMALLEST_RADIUS_PX) continue;
    const reach = Math.min(REACH_PX, 0.75 * minor);
    const [c, s] = [Math.cos((angle * Math.PI) / 180), Math.sin((angle * Math.PI) / 180)];
    for (let ray = 0; ray < RAYS; ++ray) {
      const t = (2 * Math.PI * (ray + 0.5)) / RAYS;
      const [px, py] = [major * Math.cos(t), minor * Math.sin(t)];
      const length = Math.hypot(minor * Math.cos(t), major * Math.sin(t));
      const [qx, qy] = [(minor * Math.cos(t)) / length, (major * Math.sin(t)) / length];
      const [nx, ny] = [c * qx - s * qy, s * qx + c * qy];
      const profile = profileOf(picture, u + c * px - s * py, v + s * px + c * py, nx, ny, reach);
      if (!profile) continue;
      inks.push(profile.ink);
      papers.push(profile.paper);
      edges.all.add(profile.relative, profile.middle);
      if (Math.abs(nx) > ALONG) edges.sideways.add(profile.relative, profile.middle);
      if (Math.abs(ny) > ALONG) edges.upright.add(profile.relative, profile.middle);
    }
  }
  const blur = edges.all.sigma();
  if (!Number.isFinite(blur)) return null;
  return { blur, sideways: edges.sideways.sigma(), upright: edges.upright.sigma(), ink: median(inks), paper: median(papers) };
}

export const WHITE = 250;
export const BLACK = 5;

// Shares of the picture at the ends of its range, and its mean squared gradient: what focus rings are turned by
// where there is no landmark yet.
export function rangeOf({ width, height, values }) {
  let [white, black, energy] = [0, 0, 0];
  for (const value of values) {
    white += value >= WHITE;
    black += value <= BLACK;
  }
  for (let y = 1; y < height; ++y)
    for (let i = y * width + 1; i < (y + 1) * width; ++i) energy += (values[i] - values[i - 1]) ** 2 + (values[i] - values[i - width]) ** 2;
  return { white: white / values.length, black: black / values.length, energy: energy / values.length };
}
