// What `scnrender watch` answers over HTTP: its figures, what it renders again, and that strange and
// hostile requests get nothing and do no harm.
import assert from "node:assert/strict";
import fs from "node:fs";
import net from "node:net";
import path from "node:path";
import { follow, lineOf, makeFolder, saveByRename, scene, sleep, until, watch } from "./support.mjs";

const folder = makeFolder();
const file = path.join(folder, "scene.scn");
fs.writeFileSync(path.join(folder, "paints.scn"), "let blue = rgb(0.1, 0.2, 0.8)\n");
fs.writeFileSync(file, scene);
const watched = await watch(file);
const { address } = watched;
const { state, stop } = await follow(address);
const post = (action) => fetch(address + action, { method: "POST" });
const json = async (what) => (await fetch(address + what)).json();
const done = () => until("a finished picture", async () => (await json("state")).status.phase === "done");
const tests = [];
const test = (name, run) => tests.push({ name, run });

async function picture() {
  const reply = await fetch(address + "picture");
  const [width, height, samples, number] = reply.headers.get("x-picture").split(" ").map(Number);
  const bytes = new Uint8Array(await reply.arrayBuffer());
  assert.equal(bytes.length, width * height * 4);
  let sum = 0;
  for (const byte of bytes) sum += byte;
  return { width, height, samples, number, mean: sum / bytes.length, bytes };
}

test("a picture comes, is refined and ends at the scene's samples", async () => {
  await done();
  const last = await picture();
  assert.deepEqual([last.width, last.height, last.samples], [96, 60, 16]);
  assert.ok(state.status.error > 0 && state.status.error < 1);
  assert.equal(state.scene.params.length, 5);
  assert.deepEqual(state.scene.cameras.map((camera) => camera.name), ["front", "side"]);
});

test("a setting is rendered anew", async () => {
  const before = await picture();
  assert.equal((await post("set?name=size&value=0.5m")).status, 204);
  await until("the smaller ball", async () => (await picture()).mean !== before.mean && state.scene.params[0].value === "0.5m");
  await until("the command line", () => state.view.command.endsWith("scene.scn --set size=0.5m"));
  assert.deepEqual(state.view.settings, { size: "0.5m" });
  await done();
});

test("a bad setting is told, and the picture stays", async () => {
  await post("set?name=size&value=9m");
  await until("the error", () => state.scene.errors === 1);
  assert.match(state.scene.diagnostics[0].text, /`size` must lie in 0\.2m\.\.2m/);
  assert.ok((await picture()).number > 0);
  await post("set?name=size&value=" + encodeURIComponent("1m\nsphere {}"));
  await until("the error of two items", () => state.scene.diagnostics?.[0]?.message.includes("a setting is one value"));
  await post("set?name=size");
  await until("no error", () => state.scene.errors === 0 && state.scene.params[0].value === "1m");
  await done();
});

test("exposure and tone curve render nothing", async () => {
  const before = await picture(), { seconds, worlds } = state.status;
  await post("look?exposure=2&tone=2");
  await until("the brighter picture", async () => (await picture()).mean > before.mean);
  assert.equal(state.status.phase, "done");
  assert.deepEqual([state.status.seconds, state.status.worlds], [seconds, worlds]);
  assert.equal((await picture()).number, before.number);
  await until("the command line", () => state.view.command.endsWith("--exposure 2 --tone aces"));
  await post("look");
});

test("cameras: chosen, moved, written as text, put back", async () => {
  const { worlds } = (await json("state")).status;
  await post("camera?number=1");
  await until("the camera's name", () => state.view.command.endsWith("--camera side"));
  await done();
  await post("move?kind=orbit&x=0.5&y=0.25");
  await until("the camera's text", () => state.view.camera_text.startsWith("camera { position: ("));
  await done();
  const moved = await picture(), text = state.view.camera_text;
  assert.equal((await json("state")).status.worlds, worlds, "the accelerator stays");
  // Pasted into the scene, the text gives the same picture, byte for byte.
  await post("camera?number=0");
  saveByRename(file, scene.replace(/camera \{ name: "front".*\n/, text + "\n"));
  await until("the pasted camera", () => !state.view.moved && state.scene.cameras[0].name === "");
  await done();
  await until("the same picture", async () => Buffer.compare((await picture()).bytes, moved.bytes) === 0);
  saveByRename(file, scene);
  await until("the old scene", () => state.scene.cameras[0].name === "front");
  await done();
});

test("a pixel is explained", async () => {
  const hit = await json("pixel?x=0.5&y=0.5");
  assert.equal(hit.object.kind, "sphere");
  assert.equal(hit.object.name, "ball");
  assert.equal(hit.object.line, lineOf("sphere {"));
  assert.equal(hit.material.kind, "lambert");
  assert.ok(Math.abs(hit.depth - 4) < 1e-9 && Math.abs(hit.normal[2] - 1) < 1e-9);
  assert.equal(hit.lights[0].name, "lamp");
  assert.equal(hit.lights[0].line, lineOf("area_light"));
  // E = Phi cos / (4 pi d^2) of a sphere that emits diffusely, and pi L of what is all around.
  const lamp = hit.lights[0], d = Math.hypot(3, 3, 2), cosine = 2 / d;
  assert.ok(Math.abs(lamp.irradiance / ((2000 * cosine) / (4 * Math.PI * d * d)) - 1) < 0.05, `${lamp.irradiance}`);
  const around = hit.lights[1].irradiance;
  assert.ok(Math.abs(around / (0.5 * Math.PI) - 1) < 0.1, `${around}`);
  allOfIt(hit);
  // Of a matt surface the light's part is that of the irradiance: 3.09 to 1.57.
  assert.ok(Math.abs(lamp.share - lamp.irradiance / (lamp.irradiance + around)) < 0.03, `${lamp.share}`);
  const miss = await json("pixel?x=0.01&y=0.01");
  assert.equal(miss.hit, false);
  assert.equal(miss.lights[0].kind, "environment_light");
});

// The ball is all that there is: what comes directly is all that is seen, up to the picture's noise.
function allOfIt(pixel) {
  const off = Math.abs(pixel.direct_luminance - pixel.luminance);
  assert.ok(off < 5 * pixel.luminance_error + 0.03 * pixel.luminance, `${pixel.direct_luminance}, and ${pixel.luminance} ± ${pixel.luminance_error}`);
}

test("the light that is told is the one that the material shows", async () => {
  // A polished ball shows its surroundings here; the lamp, which gives it more, stands beside the reflection.
  await post("set?name=rough&value=false");
  await until("the polished ball", async () => (await json("pixel?x=0.5&y=0.5")).material.kind === "ggx");
  await done();
  const polished = await json("pixel?x=0.5&y=0.5");
  assert.equal(polished.lights[0].kind, "environment_light");
  assert.ok(polished.lights[0].share > 0.8 && polished.lights[0].irradiance < polished.lights[1].irradiance);
  // f0 = 0.216 of the radiance 0.5 all around, as luminance; alpha 0.1 loses next to nothing.
  assert.ok(Math.abs(polished.lights[0].luminance / (683 * 0.2159 * 0.5) - 1) < 0.1, `${polished.lights[0].luminance}`);
  allOfIt(polished);
  // A mirror in which the lamp stands: halfway between the eye at (0, 0, 5) and the lamp at (3, 3, 3).
  saveByRename(file, scene.replace(/  material: if .*\n/, "  material: mirror {}\n").replace("(3, 3, 3)", "(0, 0, 12)").replace("radius: 0.4", "radius: 0.8"));
  await until("the mirror", async () => (await json("pixel?x=0.5&y=0.5")).material.kind === "mirror");
  const mirror = await json("pixel?x=0.5&y=0.5");
  assert.equal(mirror.lights[0].name, "lamp");
  assert.ok(mirror.lights[0].share > 0.999 && mirror.lights[0].luminance > 1000);
  await post("reset");
  saveByRename(file, scene);
  await until("the old scene", async () => (await json("pixel?x=0.5&y=0.5")).material.kind === "lambert");
  await done();
});

test("a saved picture says what it is of", async () => {
  await post("look?exposure=1&tone=2");
  await done();
  const { command } = (await json("state")).view;
  for (const type of ["png", "exr"]) {
    const saved = Buffer.from(await (await fetch(address + "save?type=" + type)).arrayBuffer()).toString("latin1");
    for (const text of ["scnrender:scene", "scene.scn", "scnrender:command", command, "scnrender:samples", "scnrender:error"]) {
      assert.ok(saved.includes(text), `${type}: ${text}`);
    }
  }
  assert.ok(command.endsWith("--exposure 1 --tone aces"), command);
  await post("look");
});

test("limits stand in the command line", async () => {
  const limited = await watch(file, "--limit", "nesting=150", "--limit", "steps=1000000");
  assert.ok((await (await fetch(limited.address + "state")).json()).view.command.endsWith("scene.scn --limit nesting=150 --limit steps=1000000"));
  await limited.end();
});

test("params of imported files", async () => {
  fs.writeFileSync(path.join(folder, "lib.scn"), 'param far: length = 0m in -1m..1m "How far"\nlet at = (far, 0, 0)\n');
  saveByRename(file, scene.replace("film", 'import "lib.scn" as lib\nfilm').replace("center: place", "center: lib.at"));
  await until("the param", () => state.scene.params.length === 6);
  assert.deepEqual(state.scene.params[5], { name: "lib.far", type: "length", default: "0m", value: "0m", min: "-1m", max: "1m", description: "How far" });
  await done();
  const before = await picture();
  assert.equal((await post("set?name=lib.far&value=0.5m")).status, 204);
  await until("the ball elsewhere", async () => Buffer.compare((await picture()).bytes, before.bytes) !== 0 && state.scene.params[5].value === "0.5m");
  await until("the command line", () => state.view.command.endsWith("scene.scn --set lib.far=0.5m"));
  await post("reset");
  saveByRename(file, scene);
  await until("the old scene", () => state.scene.params.length === 5);
  await done();
});

test("a focus, and a refusal of one", async () => {
  assert.equal((await post("focus?x=0.5&y=0.5")).status, 204);
  await until("the focus", () => state.view.camera_text.includes("focus_distance: 4 }"));
  const refused = await post("focus?x=0.01&y=0.01");
  assert.equal(refused.status, 422);
  assert.equal(await refused.text(), "there is nothing to focus on");
  await post("camera?number=0");
  await done();
});

test("files: an error, its end, an import, a missing one", async () => {
  fs.writeFileSync(file, scene.replace("radius: size", "radus: size"));
  await until("the error", () => state.scene.errors === 1);
  assert.match(state.scene.diagnostics[0].text, /\^\^\^\^\^ did you mean `radius`\?/);
  assert.ok((await picture()).number > 0);
  const imported = scene.replace("#808080", "paints.blue").replace("film", 'import "paints.scn" as paints\nfilm');
  saveByRename(file, imported);
  await until("no error", () => state.scene.errors === 0);
  await done();
  const blue = await picture();
  fs.writeFileSync(path.join(folder, "paints.scn"), "let blue = rgb(0.8, 0.2, 0.1)\n");
  await until("the other paint", async () => Buffer.compare((await picture()).bytes, blue.bytes) !== 0);
  fs.rmSync(path.join(folder, "paints.scn"));
  await until("the missing import", () => state.scene.errors >= 1);
  fs.writeFileSync(path.join(folder, "paints.scn"), "let blue = rgb(0.8, 0.2, 0.1)\n");
  await until("the import's return", () => state.scene.errors === 0);
  saveByRename(file, scene);
  await until("the old scene", () => state.scene.params[1].default !== "rgb(0.8, 0.2, 0.1)");
  await done();
});

test("a texture that is saved is rendered anew", async () => {
  const paint = (r, g, b) => Buffer.concat([Buffer.from("P6 1 1 255\n"), Buffer.from([r, g, b])]);
  fs.writeFileSync(path.join(folder, "paint.ppm"), paint(200, 20, 20));
  saveByRename(file, scene.replace("color: paint }", 'color: image { file: "paint.ppm" } }'));
  const middle = async () => {
    const { bytes, width, height } = await picture();
    return bytes.slice((width * (height / 2) + width / 2) * 4).slice(0, 3);
  };
  await until("a red ball", async () => { const [r, g] = await middle(); return r > 2 * g; }, 60000);
  saveByRename(path.join(folder, "paint.ppm"), paint(20, 200, 20));
  await until("a green ball", async () => { const [r, g] = await middle(); return g > 2 * r; });
  saveByRename(file, scene);
  await until("the old scene", async () => { const [r, g] = await middle(); return r === g; });
  await done();
});

test("settings that the scene doesn't take any more are dropped", async () => {
  await post("set?name=size&value=1.5m");
  await until("the setting", () => state.view.settings.size === "1.5m");
  saveByRename(file, scene.replace("param size: length = 1m in 0.2m..2m", "param width: length = 1m in 0.2m..2m").replace("radius: size", "radius: width"));
  await until("it to be gone", () => state.scene.params[0].name === "width" && state.view.settings.size === undefined);
  assert.equal(state.scene.errors, 0);
  saveByRename(file, scene);
  await until("the old scene", () => state.scene.params[0].name === "size");
  await done();
});

test("a save is answered soon", async () => {
  const times = [];
  for (let i = 0; i < 5; ++i) {
    const before = state.pictures;
    const began = performance.now();
    saveByRename(file, scene.replace("power: 2000W", `power: ${2001 + i}W`));
    await until("a picture", () => state.pictures > before);
    times.push(performance.now() - began);
    await done();
  }
  times.sort((a, b) => a - b);
  console.log(`  from the save to the picture: ${times.map((t) => t.toFixed(0)).join(", ")} ms`);
  saveByRename(file, scene);
});

test("an evaluation without end is broken off by a save", async () => {
  const endless = scene + "let _n = sum([for (i in 0..<100000) sum([for (j in 0..<100000) i * j])])\n";
  saveByRename(file, endless);
  await until("its evaluation", async () => (await json("state")).status.phase === "evaluating");
  await sleep(100);
  assert.equal((await json("state")).status.phase, "evaluating");
  saveByRename(file, scene);
  await done();
});

// --- Hostile requests ----------------------------------------------------------------------------

const { port, pathname } = new URL(address);

// Sends bytes as they are; what comes back until the server closes, or some time passes.
function raw(text, { ms = 1500 } = {}) {
  return new Promise((finished) => {
    let answer = "";
    const socket = net.connect(Number(port), "127.0.0.1", () => socket.write(text));
    const end = () => { socket.destroy(); finished(answer); };
    socket.on("data", (data) => { answer += data.toString("latin1"); });
    socket.on("error", end);
    socket.on("close", end);
    setTimeout(end, ms);
  });
}
const request = (method, target, headers = "", host = `127.0.0.1:${port}`) =>
  `${method} ${target} HTTP/1.1\r\nHost: ${host}\r\nConnection: close\r\n${headers}\r\n`;
const statusOf = async (text, options) => Number(/^HTTP\/1\.[01] (\d+)/.exec(await raw(text, options))?.[1] ?? 0);

test("without the token, or from elsewhere, nothing is told", async () => {
  const wrong = pathname.replace(/[0-9a-f]/, (c) => (c === "0" ? "1" : "0"));
  for (const target of ["/", "/index.html", "/events", "/favicon.ico", wrong, wrong + "picture", pathname.slice(0, -3), pathname.slice(0, -1), "//" + pathname.slice(1), "/" + pathname, "*", "http://127.0.0.1/"]) {
    const answer = await raw(request("GET", target));
    assert.match(answer, /^HTTP\/1\.1 (403|404|400)/, target);
    assert.ok(!answer.includes("<script"), target);
  }
  for (const host of ["evil.example", `evil.example:${port}`, "127.0.0.1.evil.example", "localhost.evil.example", "127.0.0.1:80@evil.example", "", "[::1].evil.example"]) {
    assert.equal(await statusOf(request("GET", pathname, "", host)), 403, host);
  }
  assert.equal(await statusOf(`GET ${pathname} HTTP/1.1\r\nConnection: close\r\n\r\n`) >= 400, true);
  for (const headers of ["Origin: http://evil.example\r\n", "Origin: null\r\n", `Origin: http://127.0.0.1:${Number(port) + 1}\r\n`, "Sec-Fetch-Site: cross-site\r\n"]) {
    assert.equal(await statusOf(request("POST", pathname + "reset", headers)), 403, headers);
  }
  assert.equal(await statusOf(request("POST", pathname + "reset", `Origin: http://127.0.0.1:${port}\r\nSec-Fetch-Site: same-origin\r\n`)), 204);
  assert.equal(await statusOf(request("GET", pathname, "", `localhost:${port}`)), 200);
});

test("no file but the page's is served", async () => {
  for (const name of ["../../../../etc/passwd", "..%2f..%2f..%2fetc%2fpasswd", "%2e%2e/%2e%2e/etc/passwd", "scene.scn", "page", "page.js%00.png", "page.js/", "./page.js", "events/", "picture/../scene.scn", "index.html~"]) {
    const status = await statusOf(request("GET", pathname + name));
    assert.ok(status === 404 || status === 400 || status === 403 || name.includes("%00"), `${name}: ${status}`);
  }
  const page = await raw(request("GET", pathname));
  assert.match(page, /Content-Security-Policy: default-src 'none'/);
  assert.match(page, /X-Content-Type-Options: nosniff/);
});

test("what is too large, or no request, is refused", async () => {
  assert.ok([413, 414, 431, 400, 500, 0].includes(await statusOf(request("GET", pathname + "?" + "x".repeat(200000)))));
  assert.ok([413, 431, 400, 500, 0].includes(await statusOf(request("GET", pathname, "X: " + "y".repeat(200000) + "\r\n"))));
  assert.ok([413, 431, 400, 500, 0].includes(await statusOf(request("GET", pathname, "A: b\r\n".repeat(20000)))));
  assert.equal(await statusOf(request("POST", pathname + "reset", "Content-Length: 1000000000\r\n")), 413);
  assert.equal(await statusOf(request("POST", pathname + "reset", "Content-Length: 4\r\n") + "abcd"), 413);
  assert.equal(await statusOf(request("POST", pathname + "reset", "Transfer-Encoding: chunked\r\n") + "5\r\nhello\r\n0\r\n\r\n"), 413);
  assert.ok([400, 413, 0].includes(await statusOf(request("POST", pathname + "reset", "Content-Length: -1\r\n"))));
  for (const method of ["PUT", "DELETE", "TRACE", "OPTIONS", "HEAD", "PATCH"]) {
    assert.equal(await statusOf(request(method, pathname)), 405, method);
  }
  for (const text of ["\r\n\r\n\r\n", "GET\r\n\r\n", "\x16\x03\x01\x02\x00\x01\x00\x01\xfc", "A".repeat(100000), "GET / HTTP/9.9\r\n\r\n", "\0\0\0\0"]) {
    assert.ok((await statusOf(text, { ms: 400 })) !== 200);
  }
});

test("numbers and names that make no sense are refused", async () => {
  for (const query of ["", "?x=0.5", "?x=nan&y=0", "?x=inf&y=0", "?x=1e999&y=0", "?x=-1&y=0", "?x=2&y=0", "?x=0.5;&y=0.5", "?x=0x10&y=0", `?x=${"1".repeat(3000)}&y=0`]) {
    assert.ok([400].includes((await fetch(address + "pixel" + query)).status), query);
  }
  for (const action of ["move", "move?kind=orbit", "move?kind=jump&x=1&y=1", "move?kind=dolly&x=0", "move?kind=dolly&x=-1", "move?kind=dolly&x=1e300", "move?kind=pan&x=1e300&y=0", "move?kind=fov&x=4", "move?kind=fov&x=0", "move?kind=aperture&x=-1", "camera?number=99", "look?exposure=1000", "set", "set?name=", "set?name=a%20b&value=1", "set?name=--&value=1", `set?name=size&value=${"9".repeat(5000)}`]) {
    const reply = await post(action);
    assert.equal(reply.status, 422, action);
    assert.ok((await reply.text()).length > 5);
  }
  assert.equal((await post("nothing")).status, 404);
  assert.equal(state.scene.errors, 0);
});

test("many connections, and those that say nothing, don't stop it", async () => {
  const sockets = [];
  for (let i = 0; i < 150; ++i) {
    const socket = net.connect(Number(port), "127.0.0.1");
    socket.on("error", () => {});
    if (i % 3 === 0) socket.write(`GET ${pathname} HTT`);
    sockets.push(socket);
  }
  await sleep(300);
  for (const socket of sockets) socket.destroy();
  await until("answers", async () => (await Promise.all(Array.from({ length: 16 }, () => fetch(address)))).every((reply) => reply.ok));
  assert.ok(!state.ended);
});

test("who reads nothing keeps nobody waiting", async () => {
  const sockets = [];
  for (const what of ["events", "picture", "save?type=exr"]) {
    const socket = net.connect(Number(port), "127.0.0.1", () => socket.write(request("GET", pathname + what)));
    socket.on("error", () => {});
    socket.pause();
    sockets.push(socket);
  }
  for (let i = 0; i < 30; ++i) await post(`look?exposure=${i / 10}`);
  const began = performance.now();
  await picture();
  assert.ok(performance.now() - began < 5000);
  for (const socket of sockets) socket.destroy();
  await post("look");
});

test("all at once: settings, moves, looks, pixels, pictures and saves of the file", async () => {
  for (let i = 0; i < 12; ++i) {
    const work = [];
    work.push(post(`set?name=size&value=${0.5 + i / 10}m`), post(`move?kind=orbit&x=0.1&y=0`), post(`look?exposure=${i / 10}`));
    work.push(json(`pixel?x=${i / 12}&y=0.5`), picture(), post(`pause?on=${i % 2}`), post("camera?number=" + (i % 2)));
    if (i % 4 === 0) saveByRename(file, scene.replace("fov: 40deg", `fov: ${41 + i}deg`));
    await Promise.all(work);
  }
  await post("pause?on=0");
  await post("reset");
  saveByRename(file, scene);
  await until("quiet", () => state.status.phase === "done" && state.scene.errors === 0);
});

test("a save as a file", async () => {
  const png = new Uint8Array(await (await fetch(address + "save?type=png")).arrayBuffer());
  assert.deepEqual([...png.slice(0, 4)], [0x89, 0x50, 0x4e, 0x47]);
  const exr = new Uint8Array(await (await fetch(address + "save?type=exr")).arrayBuffer());
  assert.deepEqual([...exr.slice(0, 4)], [0x76, 0x2f, 0x31, 0x01]);
});

for (const { name, run } of tests) {
  try {
    await run();
    console.log(`ok: ${name}`);
  } catch (error) {
    console.error(`FAILED: ${name}\n${error.stack}\n${JSON.stringify(state).slice(0, 1500)}\n${watched.errors()}`);
    process.exit(1);
  }
}
const end = await watched.end();
assert.deepEqual(end, { code: 0, signal: null }, "Ctrl-C ends it");
await until("the stream's end", () => state.ended);
assert.ok(!/Sanitizer/.test(watched.errors()), watched.errors());
stop();
console.log(`${tests.length} passed, 0 failed`);
process.exit(0);
