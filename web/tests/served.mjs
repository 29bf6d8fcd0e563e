// The program behind the page, with a real head: what its tests share. VOLVIS is the program. What is compared of
// pictures is the canvas, pixel by pixel.
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { existsSync, linkSync, mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { after, before } from "node:test";
import { setTimeout as sleep } from "node:timers/promises";
import { closePage, openPage, PATIENCE_MS, startBrowser, waitForPicture } from "./browser.mjs";

export const program = process.env.VOLVIS;
const DATA = process.env.VOLVIS_DATA ?? "/usr/share/mricron/templates/ch2.nii.gz";
export const skip = !program ? "VOLVIS names no program" : !existsSync(DATA) ? `${DATA} is missing` : false;

/** The head in the folder, as the program gets it: with an eighth of the voxels, for pictures in half of the time. */
export const file = basename(DATA);

/** Words of the program for tests that ask whether pictures differ, not how good they are: one ray a pixel, one pass. */
export const QUICK = [file, "--spp", "1"];

export let browser;
export let folder;
before(async () => {
  folder = mkdtempSync(join(tmpdir(), "volvis-page-"));
  if (!skip) {
    execFileSync(program, ["resample", DATA, "--spacing", "2vox", "-o", join(folder, file), "-q"]);
    browser = await startBrowser();
  }
});
after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true, force: true });
});

let places = 0;

/** A folder with the head in it and nothing else. */
export function makePlace() {
  const place = join(folder, `place-${++places}`);
  mkdirSync(place);
  linkSync(join(folder, file), join(place, file));
  return place;
}

/** The program in a place of its own, on a file there or without one; url is the link that it prints. */
export async function startProgram(words, place = makePlace()) {
  const child = spawn(program, ["view", "--no-browser", ...words], { cwd: place, env: { ...process.env, XDG_STATE_HOME: `${place}-state` }, stdio: ["ignore", "pipe", "pipe"] });
  const ended = new Promise((resolve) => child.once("exit", resolve));
  const url = await new Promise((resolve, reject) => {
    let text = "";
    const look = (data) => { text += data; const found = /http:\S+/.exec(text); if (found) resolve(found[0]); };
    child.stdout.on("data", look);
    child.stderr.on("data", look);
    child.once("exit", (code) => reject(new Error(`the program ended with ${code}: ${text}`)));
  });
  return { url, place, stop: async (signal = "SIGTERM") => { child.kill(signal); await ended; } };
}

/** A page on a program of its own, with the head in its folder. */
export async function withProgram(words, act, { place, ...options } = {}) {
  const served = await startProgram(["--fresh", ...words], place);
  try {
    const page = await openPage(browser, served.url, options);
    await act(page, served);
    assert.deepEqual(page.problems, []);
    await closePage(page);
  } finally {
    await served.stop();
  }
}

/** What is on the canvas, when it is finished; from 0 to 255, RGBA. */
export async function pixels(page) {
  await waitForPicture(page);
  return Buffer.from(await page.evaluate(`(() => {
      ${base64Source}
      const canvas = document.querySelector(".picture");
      return base64(canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data);
    })()`), "base64");
}

// As text: arrays of a million numbers take a minute on their way.
export const base64Source = `function base64(bytes) {
  let text = "";
  for (let i = 0; i < bytes.length; i += 32768) text += String.fromCharCode(...bytes.subarray(i, i + 32768));
  return btoa(text);
}`;

export function psnr(a, b) {
  if (a.length !== b.length) return 0;
  let sum = 0;
  for (let i = 0; i < a.length; i++) sum += (a[i] - b[i]) ** 2;
  return sum === 0 ? Infinity : 10 * Math.log10((255 * 255 * a.length) / sum);
}

/** From the middle of the picture, as a hand: frame by frame of the screen. */
export async function drag(page, dx, dy) {
  const box = await page.locator("[data-viewport]").boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + dx, y + dy, { steps: 10 });
  await page.mouse.up();
}

/** The first finished picture that is as wanted: what a key asks for may be asked of the server a moment later. */
async function pictureThat(page, isWanted, sentence) {
  for (const end = Date.now() + PATIENCE_MS; ; await sleep(20)) {
    const shown = await pixels(page);
    if (isWanted(shown)) return shown;
    assert.ok(Date.now() < end, sentence);
  }
}

/** A picture that shows something. */
export const seen = (page) => pictureThat(page, (shown) => shown.some((v, i) => i % 4 < 3 && v > 60), "nothing is seen");
/** Another one than `before`: below `limit` dB. */
export const changed = (page, before, limit, sentence) => pictureThat(page, (shown) => psnr(before, shown) < limit, sentence);
/** The one that was there before, to 40 dB. */
export const back = (page, before, sentence) => pictureThat(page, (shown) => psnr(before, shown) >= 40, sentence);
