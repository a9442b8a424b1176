// /api/calibrate as a page asks it, but for what a test changes of that.
import { TOKEN } from "./configuration_stage.mjs";
import { get } from "./stage.mjs";

const PATH = "/api/calibrate";
export const authorised = { Authorization: `Bearer ${TOKEN}` };

// stage: with the port of ninedot-web
export const calibrationDesk = (stage) => ({
  state: async () => JSON.parse((await get(stage.port, PATH, { headers: authorised })).body),
  post: (body, { token = TOKEN, headers = {}, port = stage.port } = {}) => get(port, PATH, { method: "POST", body,
    headers: { Origin: `http://127.0.0.1:${port}`, "Sec-Fetch-Site": "same-origin", "Content-Length": Buffer.byteLength(body), ...(token ? { Authorization: `Bearer ${token}` } : {}), ...headers } }),
});
