// The Navigator's own drawing, by WebGL, against what the program renders of the same scene with the same method.
import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { promisify } from "node:util";
import { search, until, waitForPicture } from "./browser.mjs";
import { base64Source, drag, file, folder, program, skip, withProgram } from "./served.mjs";

const DRAWN = ".own-drawing";
const INNER = 4; // pixels from the silhouette: edges are smoothed by other samples

/** Drawings can be read after they are on the screen. */
function keepDrawings() {
  const get = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, options) { return get.call(this, kind, kind === "webgl2" ? { ...options, preserveDrawingBuffer: true } : options); };
}

const choose = (page, choice) => page.getByLabel("Drawing while the Navigator moves").selectOption(choice);

async function drawAlways(page, choice) {
  await choose(page, choice);
  await page.getByRole("button", { name: "The page also draws at rest" }).click();
  await settled(page);
}

/** Shown, with the finest surface that it will ask for. */
async function settled(page) {
  await page.getByText("drawn by the page").waitFor();
  await waitForPicture(page);
}

/** RGBA, top row first. */
async function own(page) {
  const [width, height, data] = await page.evaluate(`(() => {
      ${base64Source}
      const canvas = document.querySelector("${DRAWN}");
      const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
      copy.drawImage(canvas, 0, 0);
      return [canvas.width, canvas.height, base64(copy.getImageData(0, 0, canvas.width, canvas.height).data)];
    })()`);
  return { width, height, data: Buffer.from(data, "base64") };
}

let saved = 0;

/** The scene of the page, drawn by the program. */
async function rendered(page, { width, height }, ...words) {
  const name = join(folder, `own-${++saved}`);
  await page.keyboard.press("Control+s");
  await page.getByRole("textbox", { name: "Name" }).fill(`${name}.vv.json`);
  await page.keyboard.press("Enter");
  await page.locator("dialog").waitFor({ state: "detached" });
  await promisify(execFile)(program, ["render", `${name}.vv.json`, "-o", `${name}.png`, "--size", `${width}x${height}`, ...words]);
  const png = readFileSync(`${name}.png`).toString("base64");
  const data = await page.evaluate(`(async () => {
      ${base64Source}
      const bytes = Uint8Array.from(atob("${png}"), (c) => c.charCodeAt(0));
      const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
      const copy = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
      copy.drawImage(bitmap, 0, 0);
      return base64(copy.getImageData(0, 0, bitmap.width, bitmap.height).data);
    })()`);
  return { width, height, data: Buffer.from(data, "base64") };
}

/** What is not the black ground. */
const mask = ({ data }) => Uint8Array.from({ length: data.length / 4 }, (_, i) => (data[4 * i] + data[4 * i + 1] + data[4 * i + 2] > 24 ? 1 : 0));

function compare(a, b) {
  const [m, n] = [mask(a), mask(b)];
  let [both, either, sum, inner] = [0, 0, 0, 0];
  const { width, height } = a;
  const deep = (x, y) => {
    for (let j = -INNER; j <= INNER; j += INNER)
      for (let i = -INNER; i <= INNER; i += INNER) {
        const at = (y + j) * width + x + i;
        if (x + i < 0 || x + i >= width || y + j < 0 || y + j >= height || !m[at] || !n[at]) return false;
      }
    return true;
  };
  for (let y = 0; y < height; y++)
    for (let x = 0; x < width; x++) {
      const at = y * width + x;
      both += m[at] & n[at];
      either += m[at] | n[at];
      if (!(m[at] & n[at]) || !deep(x, y)) continue;
      inner++;
      for (let c = 0; c < 3; c++) sum += Math.abs(a.data[4 * at + c] - b.data[4 * at + c]) / 3;
    }
  return { overlap: both / either, covered: either / m.length, difference: sum / inner };
}

async function agrees(page, method, most) {
  const drawn = await own(page);
  const { overlap, covered, difference } = compare(drawn, await rendered(page, drawn, "--method", method));
  assert.ok(covered > 0.05 && overlap >= 0.98, `${method}: ${overlap} of the silhouettes is common`);
  assert.ok(difference <= most, `${method}: colours differ by ${difference} of 255 on the mean`);
}

/** Until the page has drawn another picture than this one, and rests. */
async function redrawn(page, before) {
  await until(async () => !(await own(page)).data.equals(before.data), "the page does not draw anew");
  return settled(page);
}

test("what the page draws is what the program renders: reduced surfaces and boxes, cut, in parallel", { skip }, () => withProgram([file], async (page) => {
  await waitForPicture(page);
  await drawAlways(page, "boxes");
  let before = await own(page);
  await drag(page, 90, 30);
  await redrawn(page, before);
  await agrees(page, "boxes", 3);
  await page.locator("[data-viewport]").focus();
  await page.keyboard.press("d"); // round to the first
  await page.waitForFunction(() => document.querySelector(".overlay-select").value === "automatic");
  await choose(page, "reduced");
  await page.getByText("Reduced surface · drawn").waitFor();
  await settled(page);
  await agrees(page, "reduced", 3);
  before = await own(page);
  await page.getByRole("button", { name: "Add a cut plane" }).first().click();
  await redrawn(page, before);
  await agrees(page, "reduced", 3);
  const { width } = await own(page);
  await page.setViewportSize({ width: 951, height: 739 });
  await until(async () => (await own(page)).width !== width, "the drawing keeps its size");
  await settled(page);
  before = await own(page);
  await search(page, "perspective or parallel");
  await redrawn(page, before);
  await agrees(page, "reduced", 3);
  await choose(page, "boxes");
  await page.getByText("Boxes · drawn").waitFor();
  await settled(page);
  await agrees(page, "boxes", 3);
}, { init: keepDrawings, viewport: { width: 1117, height: 683 } }));
