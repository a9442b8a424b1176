// How a sheet is held and how it should be, drawn over the picture; and how often each part of the picture saw it.
const GHOST = "#ff3cdc", SHEET = "#ffeb00";
// Of each part as many as a good calibration has.
const ENOUGH = 3;
const COLUMNS = 3;

function path(context, points) {
  context.beginPath();
  points.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
  context.closePath();
}

// A light line on a dark one shows on paper, ink and wall alike.
function outline(context, points, colour, width, dash = []) {
  if (points.length < 3) return;
  path(context, points);
  context.setLineDash([]);
  context.strokeStyle = "rgba(0,0,0,.55)";
  context.lineWidth = 2 * width;
  context.stroke();
  context.setLineDash(dash);
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.stroke();
  context.setLineDash([]);
}

// news: of the wizard while it gathers views, or null
export function drawHolding(canvas, picture, news) {
  const width = Math.max(picture.width, Math.round(canvas.clientWidth * (window.devicePixelRatio || 1)));
  const height = Math.round((width * picture.height) / picture.width);
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const context = canvas.getContext("2d");
  const scale = width / picture.width;
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.drawImage(picture, 0, 0, width, height);
  canvas.dataset.ghost = news?.ghost ? news.ghost.meets.join(", ") : "";
  if (!news) return;
  // Pixel centres are integers: half a pixel from the picture's corner.
  context.setTransform(scale, 0, 0, scale, scale / 2, scale / 2);
  const line = Math.max(1.2, width / 420) / scale;
  if (news.ghost) {
    const [border, ...discs] = news.ghost.outlines;
    path(context, border);
    context.fillStyle = "rgba(255, 60, 220, .13)";
    context.fill();
    outline(context, border, GHOST, 1.3 * line, [6 * line, 4 * line]);
    for (const disc of discs) outline(context, disc, GHOST, line, [3 * line, 2 * line]);
  }
  outline(context, news.sheet, SHEET, 1.3 * line);
}

// news: {parts, part}
export function drawCoverage(canvas, { parts, part }) {
  const style = getComputedStyle(document.documentElement);
  const colour = (name) => style.getPropertyValue(name).trim();
  const context = canvas.getContext("2d");
  const cell = [canvas.width / COLUMNS, canvas.height / COLUMNS];
  context.clearRect(0, 0, canvas.width, canvas.height);
  context.textAlign = "center";
  context.textBaseline = "middle";
  parts.forEach((count, i) => {
    const [x, y] = [(i % COLUMNS) * cell[0], Math.floor(i / COLUMNS) * cell[1]];
    context.fillStyle = colour("--good");
    context.globalAlpha = 0.08 + (0.37 * Math.min(count, ENOUGH)) / ENOUGH;
    context.fillRect(x + 2, y + 2, cell[0] - 4, cell[1] - 4);
    context.globalAlpha = 1;
    context.strokeStyle = colour(i === part ? "--accent" : "--line");
    context.lineWidth = i === part ? 5 : 2;
    context.strokeRect(x + 4, y + 4, cell[0] - 8, cell[1] - 8);
    context.fillStyle = colour("--ink");
    context.font = "600 30px system-ui, sans-serif";
    context.fillText(String(count), x + cell[0] / 2, y + cell[1] / 2);
  });
}
