// compare's report, opened from disk in headless Chromium: no errors, every picture there, the slider
// moves what is seen, and nothing is wider than a phone, in light and dark.
//     node report_test.mjs INDEX.html       PICTURES=DIR keeps screenshots there.
import assert from "node:assert/strict";
import { createRequire } from "node:module";
import path from "node:path";
import { pathToFileURL } from "node:url";

const { chromium } = createRequire(path.join(process.env.MODULES, "index.js"))("playwright-core");
const address = pathToFileURL(path.resolve(process.argv[2])).href;
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM,
  args: ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync"],
});
let passed = 0;

async function open(viewport, colorScheme) {
  const page = await (await browser.newContext({ viewport, colorScheme })).newPage();
  const complaints = [];
  page.on("pageerror", (error) => complaints.push(error.stack));
  page.on("console", (message) => message.type() === "error" && complaints.push(message.text()));
  page.on("requestfailed", (request) => complaints.push("failed: " + request.url()));
  page.on("request", (request) => /^(file|data):/.test(request.url()) || complaints.push("asked for " + request.url()));
  await page.goto(address);
  await page.evaluate(() => Promise.all([...document.images].map((image) => { image.loading = "eager"; return image.decode(); })));
  return { page, complaints };
}

async function keep(page, name) {
  if (process.env.PICTURES) {
    await page.screenshot({ path: path.join(process.env.PICTURES, name), fullPage: true });
  }
}

async function test(name, run) {
  await run();
  console.log("ok " + ++passed + " - " + name);
}

try {
  const { page, complaints } = await open({ width: 1280, height: 900 }, "light");
  const scenes = await page.locator("article").count();
  await test("a verdict, and what was compared", async () => {
    assert.ok(scenes > 0);
    assert.match(await page.locator("#verdict").innerText(), /\d/);
    assert.equal(await page.locator(".summary tbody tr").count(), scenes);
    assert.equal(await page.locator(".wipe").count(), scenes);
    assert.ok(await page.locator("table.regions tbody tr").count() >= 2 * scenes);
  });
  await test("every picture is there", async () => {
    const broken = await page.evaluate(() => [...document.images].filter((i) => !(i.naturalWidth > 0)).map((i) => i.src));
    assert.deepEqual(broken, []);
    assert.ok(await page.locator(".side img").count() >= 2 * scenes);
    assert.equal((await page.locator(".maps img").count()) % 3, 0);
  });
  const wipe = page.locator(".wipe").first(), over = wipe.locator(".over"), slider = wipe.locator("input");
  const clip = () => over.evaluate((image) => {
    const right = getComputedStyle(image).clipPath.match(/inset\(0(?:px)? (.+?)(?: 0(?:px)? 0(?:px)?)?\)$/)[1];
    const probe = document.createElement("div");
    probe.style.cssText = "position:absolute;left:0;top:0;width:" + right;
    image.parentElement.append(probe);
    const part = 1 - probe.getBoundingClientRect().width / image.getBoundingClientRect().width;
    probe.remove();
    return part;
  });
  await test("the slider shows more or less of the left picture", async () => {
    assert.ok(Math.abs(await clip() - 0.5) < 0.01);
    await slider.fill("20");
    assert.ok(Math.abs(await clip() - 0.2) < 0.01);
    await slider.focus();
    await page.keyboard.press("End");
    assert.ok(Math.abs(await clip() - 1) < 0.01);
  });
  await test("dragging in the picture moves it, too", async () => {
    const box = await wipe.locator(".stage").boundingBox();
    await page.mouse.move(box.x + 0.9 * box.width, box.y + box.height / 2);
    await page.mouse.down();
    await page.mouse.move(box.x + 0.25 * box.width, box.y + box.height / 2, { steps: 4 });
    await page.mouse.up();
    assert.ok(Math.abs(await clip() - 0.25) < 0.01);
    assert.ok(Math.abs(Number(await slider.inputValue()) - 25) < 1);
  });
  await test("what is seen left and right of it differs as the pictures do", async () => {
    const seen = async () => (await wipe.locator(".stage").screenshot()).toString("base64");
    await slider.fill("100");
    const left = await seen();
    await slider.fill("0");
    const right = await seen();
    await wipe.locator(".left").selectOption({ index: 1 }); // the same as on the right
    await slider.fill("100");
    await over.evaluate((image) => image.decode());
    const same = await seen();
    await slider.fill("0");
    assert.notEqual(left, right);
    // But for the bar, which stands elsewhere.
    assert.notEqual(same, left);
    assert.equal(await over.getAttribute("src"), await wipe.locator(".under").getAttribute("src"));
  });
  await keep(page, "wide_light.png");
  await test("no errors, and nothing asked of a network", async () => assert.deepEqual(complaints, []));
  for (const scheme of ["light", "dark"]) {
    const narrow = await open({ width: 360, height: 740 }, scheme);
    await test("a phone, " + scheme, async () => {
      const wide = await narrow.page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
      assert.equal(wide, 0);
      const colors = await narrow.page.evaluate(() => {
        const style = getComputedStyle(document.body);
        return [style.color, style.backgroundColor].map((c) => c.match(/[\d.]+/g).slice(0, 3).reduce((a, b) => a + Number(b), 0));
      });
      assert.ok(scheme === "dark" ? colors[0] > 500 && colors[1] < 200 : colors[0] < 200 && colors[1] > 500);
      assert.deepEqual(narrow.complaints, []);
    });
    await keep(narrow.page, "narrow_" + scheme + ".png");
  }
  const dark = await open({ width: 1280, height: 900 }, "dark");
  await keep(dark.page, "wide_dark.png");
  console.log(passed + " passed, 0 failed");
} finally {
  await browser.close();
}
