// A scene in a folder of its own, watched.
import { spawn } from "node:child_process";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";

export const scene = `film { width: 96, height: 60 }
render { samples: 16 }
camera { name: "front", position: (0, 0, 5), look_at: (0, 0, 0), fov: 40deg }
camera { name: "side", position: (5, 0, 0), look_at: (0, 0, 0), fov: 40deg }
param size: length = 1m in 0.2m..2m "How large the ball is"
param shade: color = #808080
param rough: bool = true
param place: vector = (0, 0, 0)
param tint: string = "none" in ["none", "warm"]
let paint = if (tint == "warm") rgb(0.8, 0.4, 0.2) else shade
sphere {
  name: "ball", center: place, radius: size
  material: if (rough) lambert { color: paint } else ggx { f0: paint, alpha: 0.1 }
}
environment_light { radiance: 0.5 }
area_light { shape: sphere { center: (3, 3, 3), radius: 0.4 }, power: 2000W, name: "lamp" }
`;

export const lineOf = (what) => scene.slice(0, scene.indexOf(what)).split("\n").length;

export const sleep = (ms) => new Promise((done) => setTimeout(done, ms));
const patience = process.env.SANITIZE ? 6 : 1;

export async function until(what, test, ms = 20000) {
  const end = Date.now() + ms * patience;
  let last;
  for (;;) {
    try {
      last = await test();
      if (last) return last;
    } catch (error) {
      last = error;
    }
    if (Date.now() > end) throw new Error(`waited in vain: ${what} (last: ${last})`);
    await sleep(20);
  }
}

export function makeFolder() {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "scnrender-watch-"));
  process.on("exit", () => fs.rmSync(folder, { recursive: true, force: true }));
  return folder;
}

// As careful editors do: a new file takes the old one's place.
export function saveByRename(file, text) {
  fs.writeFileSync(file + "~", text);
  fs.renameSync(file + "~", file);
}

export async function watch(file, ...options) {
  const child = spawn(process.env.SCNRENDER, ["watch", file, ...options], { stdio: ["ignore", "pipe", "pipe"] });
  process.on("exit", () => child.kill("SIGKILL"));
  let output = "", errors = "";
  child.stdout.on("data", (data) => { output += data; });
  child.stderr.on("data", (data) => { errors += data; });
  const ended = new Promise((done) => child.on("exit", (code, signal) => done({ code, signal })));
  const address = await until("the address on the first line", () => /^(http:\S+)\n/.exec(output)?.[1]);
  return { child, address, errors: () => errors, async end(signal = "SIGINT") {
    child.kill(signal);
    return Promise.race([ended, sleep(20000 * patience).then(() => { throw new Error("it doesn't end"); })]);
  } };
}

// The newest state, as the stream of events tells it.
export async function follow(address) {
  const state = { pictures: 0 };
  const stop = new AbortController();
  const reply = await fetch(address + "events", { signal: stop.signal });
  (async () => {
    let text = "";
    const decoder = new TextDecoder();
    for await (const chunk of reply.body) {
      text += decoder.decode(chunk, { stream: true });
      for (let end; (end = text.indexOf("\n\n")) >= 0; text = text.slice(end + 2)) {
        const match = /^event: (\w+)\ndata: (.*)$/.exec(text.slice(0, end));
        if (match) {
          state[match[1]] = JSON.parse(match[2]);
          if (match[1] === "picture") state.pictures += 1;
        }
      }
    }
    state.ended = true;
  })().catch(() => { state.ended = true; });
  return { state, stop: () => stop.abort() };
}
