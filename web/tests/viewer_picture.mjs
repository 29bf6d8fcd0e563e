// The picture of the page in the README: node viewer_picture.mjs PROGRAM OUT.png (tools/viewer-picture).
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { openPage, startBrowser, waitForPicture } from "./browser.mjs";

const [program, out] = process.argv.slice(2);
const SCENE = new URL("../../scenes/head-cut.vv.json", import.meta.url).pathname;
const state = mkdtempSync(join(tmpdir(), "volvis-picture-"));
const child = spawn(program, ["view", "--no-browser", "--fresh", SCENE], { env: { ...process.env, XDG_STATE_HOME: state } });
const browser = await startBrowser();
try {
  const url = await new Promise((resolve, reject) => {
    let text = "";
    const look = (data) => { text += data; const found = /http:\S+/.exec(text); if (found) resolve(found[0]); };
    child.stdout.on("data", look);
    child.stderr.on("data", look);
    child.once("exit", () => reject(new Error(text)));
  });
  const page = await openPage(browser, url, { viewport: { width: 1280, height: 800 } });
  await waitForPicture(page);
  await page.mouse.move(600, 790);
  await page.waitForTimeout(1000);
  await waitForPicture(page);
  await page.screenshot({ path: out });
} finally {
  await browser.close();
  child.kill();
  rmSync(state, { recursive: true, force: true });
}
