// A plan of the world: a canvas that shows it from above, x to the right and y upwards, with a grid in metres.
import { colour, fitted, niceStep } from "./plot.js";
import { rotationOf, times } from "./projection.js";

// Beyond what there is to see, on each side.
const MARGIN = 0.12;

export class Plan {
  constructor(canvas) {
    this.canvas = canvas;
    this.bounds = null;
  }

  // Empty but for the grid. places: [mm] of all that will be drawn. Afterwards: `context`, `scale` [px/mm], and `at`,
  // where a place is.
  begin(places) {
    const { context, width, height } = fitted(this.canvas);
    this.fit(places.length ? places : [[0, 0, 0]]);
    const scale = Math.min(width, height) / this.size;
    const centre = this.bounds.map(([low, high]) => (low + high) / 2);
    const at = ([x, y]) => [width / 2 + (x - centre[0]) * scale, height / 2 - (y - centre[1]) * scale];
    Object.assign(this, { context, scale, at });
    this.drawGrid(width, height, centre);
  }

  // Grows with what is shown; shrinks only when most of it is empty, so that the plan does not breathe.
  fit(places) {
    const wanted = [0, 1].map((i) => [Math.min(...places.map((p) => p[i])), Math.max(...places.map((p) => p[i]))]);
    const size = Math.max(1000, wanted[0][1] - wanted[0][0], wanted[1][1] - wanted[1][0]);
    const inside = this.bounds && wanted.every(([low, high], i) => low >= this.bounds[i][0] && high <= this.bounds[i][1]);
    if (inside && size > 0.5 * this.size) return;
    this.size = size * (1 + 2 * MARGIN);
    this.bounds = wanted.map(([low, high]) => [(low + high - this.size) / 2, (low + high + this.size) / 2]);
  }

  drawGrid(width, height, centre) {
    const { context, scale, at } = this;
    const step = niceStep(width / scale, 8);
    context.lineWidth = 1;
    context.strokeStyle = colour("--line");
    context.fillStyle = colour("--soft");
    const range = (middle, pixels) => {
      const half = pixels / scale / 2;
      const list = [];
      for (let v = Math.ceil((middle - half) / step) * step; v < middle + half; v += step) list.push(v);
      return list;
    };
    context.beginPath();
    for (const x of range(centre[0], width)) {
      const [px] = at([x, 0]);
      context.moveTo(Math.round(px) + 0.5, 0);
      context.lineTo(Math.round(px) + 0.5, height);
      context.textAlign = "center";
      if (px > 60) context.fillText(`${(x / 1000).toFixed(step < 1000 ? 1 : 0)}`, px, height - 6);
    }
    for (const y of range(centre[1], height)) {
      const [, py] = at([0, y]);
      context.moveTo(0, Math.round(py) + 0.5);
      context.lineTo(width, Math.round(py) + 0.5);
      context.textAlign = "left";
      if (py < height - 24) context.fillText(`${(y / 1000).toFixed(step < 1000 ? 1 : 0)}`, 6, py - 4);
    }
    context.stroke();
    context.textAlign = "right";
    context.fillText("x to the right, y up, in m", width - 8, 16);
  }

  // A bar along the sheet, a tick where it faces, its number behind it.
  landmark(landmark, ink) {
    const { context, at } = this;
    const heading = (landmark.heading_deg * Math.PI) / 180;
    const facing = landmark.q ? times(rotationOf(landmark.q), [0, 1, 0]) : [-Math.sin(heading), Math.cos(heading)];
    const [x, y] = at(landmark.mm);
    context.strokeStyle = context.fillStyle = ink;
    context.lineWidth = 5;
    context.beginPath();
    context.moveTo(x + 12 * facing[1], y + 12 * facing[0]);
    context.lineTo(x - 12 * facing[1], y - 12 * facing[0]);
    context.stroke();
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(x + 16 * facing[0], y - 16 * facing[1]);
    context.stroke();
    context.textAlign = "center";
    context.font = "600 14px system-ui, sans-serif";
    context.fillText(String(landmark.id), x - 24 * facing[0], y + 24 * facing[1] + 5);
    context.font = "12px system-ui, sans-serif";
  }

  // radii: [mm] along x and y
  ellipse(mm, radii, ink) {
    const { context, scale } = this;
    context.fillStyle = ink;
    context.globalAlpha = 0.25;
    context.beginPath();
    context.ellipse(...this.at(mm), ...radii.map((radius) => Math.max(2, radius * scale)), 0, 0, 2 * Math.PI);
    context.fill();
    context.globalAlpha = 1;
  }
}
