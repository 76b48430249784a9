// The page in a browser: it is up within a second, the picture moves, and the curve lies on the
// rope. Pause, history and keys work, a click makes a mask, and four clicks make the table's plane.
// It continues when the rig or the server is restarted. On request, it also checks that neither
// browser nor server grows in ten minutes.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { chromium } from "playwright-core";
import { chain, folder as started, holds, page as serve } from "./processes.mjs";

const [, , lariat, executablePath, folder] = process.argv;
const minutes = Number(process.env.LARIAT_VIEW_MINUTES ?? 0);

let rig = await chain(lariat, "--seed", "3");
let view = await serve(lariat);
const address = view.found[0];
const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, colorScheme: "dark", acceptDownloads: true });
const page = await context.newPage();
const faults = [];
page.on("pageerror", (error) => faults.push(error.message));
page.on("console", (message) => message.type() === "error" && !message.text().includes("WebSocket") && faults.push(message.text()));
page.on("request", (request) => request.url().startsWith(address.slice(0, -1)) || request.url().startsWith("blob:") || faults.push(request.url()));

const frame = () => page.evaluate(() => Number(document.documentElement.dataset.frame ?? 0));
const text = (id) => page.locator(`#${id}`).textContent();

const began = performance.now();
await page.goto(address);
await holds("a frame is shown", async () => (await frame()) > 0);
console.log(`page up, with its first frame, after ${(performance.now() - began).toFixed(0)} ms`);

const first = await frame();
await holds("the picture moves", async () => (await frame()) > first + 10);
await holds("the state is live", async () => (await text("state")) === "live");

await page.keyboard.press(" ");
await holds("it is paused", async () => (await text("state")) === "paused");

// Both files of the displayed frame.
const downloads = [];
page.on("download", (download) => downloads.push(download));
await page.keyboard.press("s");
await holds("two files are saved", () => downloads.length === 2);
const saved = Object.fromEntries(await Promise.all(downloads.map(async (download) => [
  download.suggestedFilename().split(".").pop(), await readFile(await download.path())])));
const said = JSON.parse(saved.json);
assert.deepEqual([...saved.png.subarray(1, 4)], [..."PNG"].map((c) => c.charCodeAt(0)));

// Where the curve is reported, the canvas has the curve's color; with the picture alone, the
// rope's.
const toggle = async (...layers) => {
  for (const layer of layers) await page.click(`[data-layer=${layer}]`);
  await page.waitForTimeout(200);
};
const share = async (test) => {
  const pixels = await page.evaluate(({ curve, width, height }) => {
    const canvas = document.getElementById("canvas");
    const scale = Math.min(canvas.width / width, canvas.height / height);
    const at = ([x, y]) => [
      Math.floor(canvas.width / 2 + (x + 0.5 - width / 2) * scale),
      Math.floor(canvas.height / 2 + (y + 0.5 - height / 2) * scale),
    ];
    return curve.map((point) => [...canvas.getContext("2d").getImageData(...at(point), 1, 1).data]);
  }, { ...said, curve: said.ropes[0].curve });
  return pixels.filter(test).length / pixels.length;
};
const others = ["centerline", "control", "crossings", "tracks", "hidden"];
await toggle(...others);
const drawn = await share(([r, g, b]) => r > 180 && g > 110 && b < 110);
assert.ok(drawn > 0.9, `the curve is drawn where it is said to be: ${drawn} of it`);
await toggle("curve");
assert.ok(await share(([r, , b]) => b > r + 30) > 0.9, "the rope is where the curve is said to be");
await toggle("curve", ...others);

// Back, forward, and to the newest.
const paused = said.number;
await page.keyboard.press("ArrowLeft");
await holds("one frame back", async () => (await frame()) < paused);
await page.keyboard.press("ArrowRight");
await holds("and on", async () => (await frame()) === paused);

await page.keyboard.press("End");
await holds("it goes on", async () => (await frame()) > paused + 5);

// A click on the rope makes a mask.
await page.keyboard.press(" ");
await page.keyboard.press("p");
await page.locator("#tuning h2").first().waitFor();
const rope = await page.evaluate(() => {
  const canvas = document.getElementById("canvas");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  const at = data.findIndex((red, i) => i % 4 === 0 && red < 70 && data[i + 2] - red > 90) / 4;
  const { left, top } = canvas.getBoundingClientRect();
  return [left + (at % canvas.width) + 2, top + Math.floor(at / canvas.width) + 2];
});
await page.mouse.click(...rope);
await holds("the colours are shown", async () => (await page.locator("#tuning code").count()) > 0);
assert.match(await page.locator("#tuning code").first().textContent(), /hue_deg/);
await page.click("text=Hide the mask");
await page.keyboard.press("f");
await page.keyboard.press("End");

// Four points make the table's plane, which is drawn over the picture, used, and saved.
await page.keyboard.press("c");
const corners = [[80, 60], [560, 60], [600, 440], [40, 440]];
for (const pixel of corners) {
  const place = await page.evaluate(([x, y]) => {
    const box = document.getElementById("stage").getBoundingClientRect();
    const scale = Math.min(box.width / 640, box.height / 480);
    return [box.left + box.width / 2 + (x + 0.5 - 320) * scale, box.top + box.height / 2 + (y + 0.5 - 240) * scale];
  }, pixel);
  await page.mouse.click(...place);
}
const plane = page.locator("#tuning section", { hasText: "Table's plane" });
await holds("the points are judged", async () => (await plane.textContent()).includes("Four points determine the plane"));
assert.deepEqual(await plane.locator("input").evaluateAll((all) => all.map((one) => one.valueAsNumber)), [0, 0, 297, 0, 297, 210, 0, 210]);
// At the first corner, two grid lines cross: checks for their color between the arms of the mark.
const isGrid = () => page.evaluate(([[ax, ay], [bx, by]]) => {
  const canvas = document.getElementById("canvas");
  const scale = Math.min(canvas.width / 640, canvas.height / 480);
  const pen = canvas.getContext("2d");
  let found = 0;
  for (let part = 0.1; part < 0.9; part += 0.01) {
    const x = canvas.width / 2 + (ax + (bx - ax) * part + 0.5 - 320) * scale;
    const y = canvas.height / 2 + (ay + (by - ay) * part + 0.5 - 240) * scale;
    const { data } = pen.getImageData(Math.round(x) - 1, Math.round(y) - 1, 3, 3);
    found += Array.from({ length: 9 }, (_, i) => data.slice(4 * i, 4 * i + 3)).some(([r, g, b]) => r < 160 && g > 170 && b > 200);
  }
  return found > 60;
}, corners);
await holds("the grid is drawn", isGrid);
await page.screenshot({ path: `${folder}/plane.png` });
await plane.locator("input").nth(2).fill("");
await holds("a point without a number is waited for", async () => plane.locator("text=Use it").isDisabled());
await plane.locator("input").nth(2).fill("290");
await holds("and judged again", async () => plane.locator("text=Use it").isEnabled());
await plane.locator("text=Use it").click();
await holds("the plane is written", async () => (await plane.textContent()).includes("written into"));
assert.match(await readFile(`${started}/plane.toml`, "utf8"), /homography/);
await page.click("text=Write to lariat.toml");
await holds("it is kept", async () => (await readFile(`${started}/lariat.toml`, "utf8").catch(() => "")).includes("plane.toml"));
await plane.locator("text=Clear").click();
await page.keyboard.press("End");
await page.keyboard.press("f");
await holds("ropes are in millimetres", async () => (await text("ropes")).includes("mm"));

// The server restarts: the page continues, and may change settings as before.
const port = new URL(address).port;
await view.end();
await holds("the page says that the server is gone", async () => (await text("state")).includes("server is gone"));
view = await serve(lariat, port);
const last = await frame();
await holds("the page goes on with the next server", async () => (await text("state")) === "live" && (await frame()) !== last);
await page.keyboard.press("e");
await page.click("text=Automatic");
await holds("and changes settings", async () => (await text("tuning")).includes("nothing has changed"));
await page.keyboard.press("f");

// The rig restarts.
await rig.end();
await holds("the page says what to start", async () => (await text("obstacle")).includes("lariat run --rig cell"));
rig = await chain(lariat, "--seed", "5");
const before = await frame();
await holds("the picture moves again", async () => (await frame()) !== before && (await text("state")) === "live");

for (const [theme, width] of [["dark", 1280], ["light", 1280], ["dark", 3840]]) {
  await page.emulateMedia({ colorScheme: theme });
  await page.setViewportSize({ width, height: Math.round(width / 1.6) });
  await page.waitForTimeout(1500);
  await page.screenshot({ path: `${folder}/${theme}-${width}.png` });
  const hasRoom = await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth);
  assert.ok(hasRoom, `${width} px are wide enough`);
}

if (minutes > 0) {
  await page.setViewportSize({ width: 1280, height: 800 });
  const devtools = await context.newCDPSession(page);
  const server = async () => Number((await readFile(`/proc/${view.pid}/status`, "utf8")).match(/VmRSS:\s+(\d+)/)[1]) / 1024;
  const heap = async () => {
    await devtools.send("HeapProfiler.collectGarbage");
    return (await devtools.send("Runtime.getHeapUsage")).usedSize / 2 ** 20;
  };
  // The history is full after 30 s.
  await page.waitForTimeout(45_000);
  const start = [await heap(), await server()];
  await page.waitForTimeout(minutes * 60_000);
  const end = [await heap(), await server()];
  const shown = (mib) => mib.map((x) => x.toFixed(1)).join(", ");
  console.log(`after ${minutes} min: heap and server ${shown(end)} MiB, before ${shown(start)} MiB`);
  assert.ok(end[0] < start[0] * 1.2 + 5 && end[1] < start[1] * 1.2 + 5, "neither grows");
}

assert.deepEqual(faults, []);
await browser.close();
await view.end();
await rig.end();
console.log("the page is as it should be");
