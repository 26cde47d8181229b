// The page of `scnrender watch` in headless Chromium: the picture appears, controls change it, an error
// shows and heals, a click tells the line, on a laptop and a phone, in light and dark, by keyboard.
// PICTURES=DIR keeps screenshots there.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import fs from "node:fs";
import http from "node:http";
import { createRequire } from "node:module";
import path from "node:path";
import { lineOf, makeFolder, saveByRename, scene, sleep, until, watch } from "./support.mjs";

const { chromium } = createRequire(path.join(process.env.MODULES, "index.js"))("playwright-core");
const folder = makeFolder();
const file = path.join(folder, "scene.scn");
fs.writeFileSync(file, scene);
const watched = await watch(file);
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM,
  args: ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync"],
});
const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, permissions: ["clipboard-read", "clipboard-write"] });
const page = await context.newPage();
page.setDefaultTimeout(20000);
const complaints = [];
page.on("pageerror", (error) => complaints.push(error.stack));
page.on("console", (message) => message.type() === "error" && complaints.push(message.text()));
const foreign = [];
page.on("request", (request) => request.url().startsWith(watched.address) || foreign.push(request.url()));

const tests = [];
const test = (name, run) => tests.push({ name, run });
const canvas = page.locator("#picture");
const state = async () => (await fetch(watched.address + "state")).json();
// The picture on the screen, once it is the finished one.
async function shown() {
  await until("a finished picture", async () => (await state()).status.phase === "done");
  const wanted = (await fetch(watched.address + "picture")).headers.get("x-picture").split(" ")[3];
  await until("it on the page", async () => (await canvas.getAttribute("data-number")) === wanted);
  await sleep(50);
  return canvas.evaluate((c) => {
    const { data } = c.getContext("2d").getImageData(0, 0, c.width, c.height);
    let sum = 0;
    for (let i = 0; i < data.length; i += 4) sum += data[i] + data[i + 1] + data[i + 2];
    return { mean: sum / data.length, width: c.width, height: c.height };
  });
}
const keep = async (name) => process.env.PICTURES && page.screenshot({ path: path.join(process.env.PICTURES, name + ".png") });
const place = async (x, y) => {
  const box = await canvas.boundingBox();
  return [box.x + x * box.width, box.y + y * box.height];
};

test("the picture appears", async () => {
  await page.goto(watched.address);
  const picture = await shown();
  assert.deepEqual([picture.width, picture.height], [96, 60]);
  assert.ok(picture.mean > 10, `${picture.mean}`);
  assert.equal(await page.title(), "scene.scn – scnrender");
  assert.match(await page.locator("#phase").innerText(), /done/);
  await keep("laptop");
});

test("a control for each param, by its type", async () => {
  const kinds = await page.locator("#params [id^=param-]").evaluateAll((all) => all.map((e) => e.id + " " + (e.type || e.tagName)));
  assert.deepEqual(kinds, ["param-size range", "param-size-n number", "param-shade color", "param-rough checkbox",
    "param-place number", "param-place-1 number", "param-place-2 number", "param-tint select-one"]);
  assert.equal(await page.locator("#param-size").getAttribute("max"), "2");
  assert.ok(await page.locator("#params").innerText().then((text) => text.includes("How large the ball is")));
});

test("a slider changes the picture, by keyboard", async () => {
  const before = await shown();
  await page.locator("#param-size").focus();
  for (let i = 0; i < 20; ++i) await page.keyboard.press("ArrowRight");
  await until("the setting", async () => (await state()).view.settings.size);
  const after = await shown();
  assert.ok(Math.abs(after.mean - before.mean) > 1, `${before.mean} ${after.mean}`);
  assert.equal(await page.locator("#param-size-n").inputValue(), String(parseFloat((await state()).view.settings.size)));
  await page.getByRole("button", { name: "size as the scene says" }).click();
  await until("the slider's return", async () => (await page.locator("#param-size").inputValue()) === "1");
});

test("switch, colour, choice and vector", async () => {
  await page.locator("#param-rough").uncheck();
  await page.locator("#param-tint").selectOption("warm");
  await page.locator("#param-shade").fill("#336699");
  await page.locator("#param-place-1").fill("0.25");
  await page.locator("#param-place-1").press("Enter");
  await until("the settings", async () => {
    const { settings } = (await state()).view;
    return settings.rough === "false" && settings.tint === "warm" && settings.shade === "#336699" && settings.place === "(0, 0.25, 0)";
  });
  await shown();
  assert.equal((await state()).scene.errors, 0);
  await page.locator("#reset-params").click();
  await until("the scene's own", async () => Object.keys((await state()).view.settings).length === 0);
});

test("what is being typed is left alone by what changes meanwhile", async () => {
  const typed = page.locator("#param-size-n");
  await typed.fill("1.5");
  await fetch(watched.address + "set?name=tint&value=warm", { method: "POST" });
  await until("the other setting", async () => (await page.locator("#param-tint").inputValue()) === "warm");
  assert.equal(await typed.inputValue(), "1.5");
  await typed.press("Enter");
  await until("the setting", async () => (await state()).view.settings.size === "1.5m");
  await page.locator("#reset-params").click();
  await until("the scene's own", async () => Object.keys((await state()).view.settings).length === 0);
});

test("an error shows, the picture stays, and it heals", async () => {
  await shown();
  fs.writeFileSync(file, scene.replace("radius: size", "radus: size"));
  const problem = page.locator(".problem.error");
  await problem.waitFor();
  const text = await problem.innerText();
  assert.match(text, /error\[E0301\]: `radus` is not a field of `sphere`/);
  assert.match(text, /\^\^\^\^\^ did you mean `radius`\?/);
  assert.match(await page.locator("#phase").innerText(), /last good picture/);
  assert.ok((await canvas.getAttribute("data-number")) > 0);
  await keep("error");
  saveByRename(file, scene);
  await page.locator("#problems").waitFor({ state: "hidden" });
  assert.match(await page.locator("#phase").innerText(), /done|rendering|evaluating/);
});

test("a click tells the line", async () => {
  await shown();
  await page.mouse.click(...(await place(0.5, 0.5)));
  const pixel = page.locator("#pixel dl");
  await pixel.waitFor();
  const text = await pixel.innerText();
  assert.ok(text.includes(`ball (sphere) scene.scn:${lineOf("sphere {")}`), text);
  assert.ok(text.includes(`lamp (area_light) scene.scn:${lineOf("area_light")}`), text);
  assert.match(text, /depth\s+4 m/);
  assert.match(text, /luminance\s+[\d.]+ ± [\d.]+ cd\/m²/);
  await keep("pixel");
});

test("exposure renders nothing", async () => {
  const before = await shown(), { seconds } = (await state()).status;
  await page.locator("#exposure-number").fill("-2");
  await page.locator("#exposure-number").press("Enter");
  await until("the darker picture", async () => (await shown()).mean < before.mean / 1.3);
  assert.equal((await state()).status.seconds, seconds);
  await page.locator("#reset-look").click();
  await until("the old picture", async () => (await shown()).mean === before.mean);
});

test("a drag turns the camera, and the command line gives the picture that is saved", async () => {
  await shown();
  await page.mouse.move(...(await place(0.3, 0.5)));
  await page.mouse.down();
  await page.mouse.move(...(await place(0.45, 0.6)), { steps: 4 });
  await page.mouse.up();
  await page.locator("#camera-text").waitFor();
  await page.locator("#exposure-number").fill("0.5");
  await page.locator("#exposure-number").press("Enter");
  await page.locator("#tone").selectOption({ label: "aces" });
  await until("the curve", async () => (await state()).view.tone === 2);
  await shown();
  await until("one request after the other", async () => (await page.locator("#camera-text").inputValue()) === (await state()).view.camera_text);
  await page.locator("#copy-command").click();
  await until("the command line", async () => (await page.evaluate(() => navigator.clipboard.readText())) === (await state()).view.command);
  const command = await page.evaluate(() => navigator.clipboard.readText());
  assert.match(command, /^scnrender render \S+ --camera 'camera \{ position: \(.*\), look_at: \(.*\).* \}' --exposure 0\.5 --tone aces$/);
  const [download] = await Promise.all([page.waitForEvent("download"), page.locator("#save-png").click()]);
  assert.equal(download.suggestedFilename(), "scene.png");
  const saved = fs.readFileSync(await download.path());
  const output = path.join(folder, "command.png");
  execFileSync("sh", ["-c", `${command.replace(/^scnrender/, '"$SCNRENDER"')} -o "${output}" -q`]);
  assert.deepEqual(pixelData(saved), pixelData(fs.readFileSync(output)));
  await page.locator("#reset-camera").click();
  await page.locator("#moved").waitFor({ state: "hidden" });
  await page.locator("#reset-look").click();
});

// The compressed pixels: the same pixels of the same writer are the same bytes.
function pixelData(png) {
  const parts = [];
  for (let at = 8; at < png.length; at += 12 + png.readUInt32BE(at)) {
    if (png.toString("latin1", at + 4, at + 8) === "IDAT") parts.push(png.subarray(at + 8, at + 8 + png.readUInt32BE(at)));
  }
  assert.ok(parts.length > 0);
  return Buffer.concat(parts).toString("base64");
}

test("the keyboard moves the camera and asks for a pixel", async () => {
  await canvas.focus();
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.press("+");
  await page.keyboard.press("Shift+ArrowUp");
  await page.locator("#moved").waitFor();
  await page.keyboard.press("0");
  await page.locator("#moved").waitFor({ state: "hidden" });
  await shown();
  await page.locator("#pixel").evaluate((box) => box.replaceChildren());
  await page.keyboard.press("x");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("Enter");
  await page.locator("#pixel dl").waitFor();
  assert.match(await page.locator("#pixel").innerText(), /ball \(sphere\)/);
  await page.keyboard.press("Escape");
});

test("a double click sets the focus; the wheel goes nearer", async () => {
  // Where the machine is busy, the picture may move under the first of two clicks: then once more.
  await until("the focus", async () => {
    await page.mouse.dblclick(...(await place(0.5, 0.5)));
    await page.waitForTimeout(300);
    return (await state()).view.camera_text.includes("focus_distance: 4 }");
  });
  await page.mouse.move(...(await place(0.5, 0.5)));
  await page.mouse.wheel(0, -200);
  await until("a nearer camera", async () => /position: \(0, 0, [34]\.\d+\)/.test((await state()).view.camera_text));
  await page.locator("#reset-camera").click();
});

test("each control has a name, and what has the focus shows it", async () => {
  const nameless = await page.evaluate(() => [...document.querySelectorAll("button, a, input, select, textarea, canvas, progress")]
    .filter((e) => !(e.getAttribute("aria-label") || e.textContent.trim() || (e.labels && e.labels.length > 0)))
    .map((e) => e.outerHTML));
  assert.deepEqual(nameless, []);
  await page.locator("#pause").focus();
  await page.keyboard.press("Tab");
  const outline = await page.evaluate(() => getComputedStyle(document.activeElement).outlineStyle);
  assert.equal(outline, "solid");
});

test("a phone's width", async () => {
  await page.setViewportSize({ width: 390, height: 844 });
  await shown();
  const [wide, box] = [await page.evaluate(() => document.documentElement.scrollWidth), await canvas.boundingBox()];
  assert.ok(wide <= 390, `${wide}`);
  assert.ok(box.width > 380 && box.y + box.height < 844, JSON.stringify(box));
  await keep("phone");
  await page.setViewportSize({ width: 1280, height: 800 });
});

test("dark", async () => {
  const ground = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const light = await ground();
  await page.emulateMedia({ colorScheme: "dark" });
  assert.notEqual(await ground(), light);
  await keep("dark");
});

test("in a frame, as an editor has it, places are links to the editor", async () => {
  const panel = `<iframe src="${watched.address}" width="700" height="600"></iframe>
    <script>addEventListener("message", (event) => { window.last = event.data; });</script>`;
  const server = http.createServer((_, reply) => reply.setHeader("Content-Type", "text/html").end(panel));
  await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
  const editor = await context.newPage();
  await editor.goto(`http://localhost:${server.address().port}/`);
  const inside = editor.frameLocator("iframe");
  await inside.locator("#picture[data-number]").click();
  await inside.locator("#pixel button.place").first().click();
  const message = await until("the message", () => editor.evaluate(() => window.last));
  assert.deepEqual({ ...message, column: 0 }, { source: "scnrender", type: "reveal", file, line: lineOf("sphere {"), column: 0 });
  await editor.close();
  server.close();
});

test("the end is told", async () => {
  assert.deepEqual(await watched.end(), { code: 0, signal: null });
  await until("it on the page", async () => (await page.locator("#phase").innerText()).includes("has ended"));
});

for (const { name, run } of tests) {
  try {
    await run();
    const mine = complaints.filter((text) => !/ERR_CONNECTION_REFUSED|ERR_INCOMPLETE|Failed to fetch|ERR_EMPTY/.test(text));
    assert.deepEqual(mine, [], "the page complains");
    assert.deepEqual(foreign, [], "the page asks elsewhere");
    console.log(`ok: ${name}`);
  } catch (error) {
    console.error(`FAILED: ${name}\n${error.stack}\n${watched.errors()}`);
    await page.screenshot({ path: path.join(process.env.PICTURES || folder, "failed.png") }).catch(() => {});
    process.exit(1);
  }
}
await browser.close();
console.log(`${tests.length} passed, 0 failed`);
process.exit(0);
