// Recordings of a walk along a wall of coded sheets, as the page itself keeps them, and where the sheets truly hang.
import fs from "node:fs";
import path from "node:path";

import { SOURCE, Stage, get, pause, until } from "./stage.mjs";

export const SHEETS = [
  { id: 1, code: "KRGBKKRB", mm: [0, 0, 1200], heading: 0 },
  { id: 2, code: "RRGKBGKB", mm: [600, 0, 1350], heading: 4 },
  { id: 3, code: "KKGRRBGB", mm: [1200, -100, 1150], heading: -6 },
  { id: 4, code: "RKBGGKRB", mm: [1750, -50, 1300], heading: 12 },
];
// At its beginning the first sheet is in the picture alone.
const WALK = [[0, -300, 1250, -90], [1.5, -300, 1250, -90], [7, 1100, 1300, -95], [9, 2100, 1150, -100], [12, 1200, 1500, -84], [16, 200, 1200, -92]]
  .map(([t, x, y, heading]) => `[[simulation.robot]]\nt_s = ${t}\nx_mm = ${x}\ny_mm = ${y}\nz_mm = 1250\nheading_deg = ${heading}\n`).join("");
const WALK_S = 16;
const LENS = path.join(SOURCE, "tests/recordings/approach/camera.yaml");

// As it stands in a configuration. places: with them
export const landmarks = (sheets, places) => sheets.map(({ id, code, mm, heading }) => `[[landmarks]]\nid = ${id}\ncode = "${code}"\n${places ? `position_mm = [${mm}]\nheading_deg = ${heading}\n` : ""}`).join("");

// Where a sheet is seen from the first one: [mm].
export function fromTheFirst({ mm }) {
  const [first] = SHEETS;
  return mm.map((value, i) => value - first.mm[i]);
}

// Into `folder`: the walk as `asked`; its beginning as one of a loss. Returns {walk, alone}: their names.
export async function recordWall(folder, token) {
  const authorised = { Authorization: `Bearer ${token}` };
  const stage = await Stage.open({
    camera: `source = "simulated"\nwidth_px = 640\nheight_px = 480\nrate_hz = 10\ncalibration = "${LENS}"`,
    extra: `${landmarks(SHEETS, true)}[simulation]\nduration_s = ${WALK_S + 3}\n${WALK}`,
    web: `token_file = "${path.join(folder, "../token")}"\nrecordings = "${folder}"`,
  });
  const state = async () => JSON.parse((await get(stage.port, "/api/recordings", { headers: authorised })).body);
  const post = (body) => get(stage.port, "/api/recordings", { method: "POST", body, headers: { ...authorised, Origin: `http://127.0.0.1:${stage.port}`, "Sec-Fetch-Site": "same-origin", "Content-Length": body.length } });
  await post("start");
  await until("it records", async () => (await state()).running?.frames >= 5);
  await pause(WALK_S * 1000);
  await post("stop");
  const { name: walk } = await until("it is kept", async () => (await state()).recordings[0]);
  await stage.close();
  const alone = "20260101-120000-loss";
  fs.cpSync(path.join(folder, walk), path.join(folder, alone), { recursive: true });
  const csv = path.join(folder, alone, "frames.csv");
  const rows = fs.readFileSync(csv, "utf8").split("\n").slice(0, 6);
  fs.writeFileSync(csv, `${rows.join("\n")}\n`);
  for (const file of fs.readdirSync(path.join(folder, alone, "frames"))) if (!rows.some((row) => row.startsWith(`${Number(file.slice(0, 6))},`))) fs.rmSync(path.join(folder, alone, "frames", file));
  return { walk, alone };
}
