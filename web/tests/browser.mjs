// What the tests in the browser share: the mock server, Chromium, axe, and waiting. Whatever is waited for is an event or a
// state that the page has, never a time; that it does not come for a minute is the failure, in words.
import { createRequire } from "node:module";
import { join } from "node:path";
import { readFileSync } from "node:fs";
import assert from "node:assert/strict";
import { setTimeout as sleep } from "node:timers/promises";
import { chromium } from "playwright-core";
import { serve } from "../mock/mock.mjs";

const axeSource = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

/** So long may a machine with much else to do take for anything. */
export const PATIENCE_MS = 180000;

/** Tests of a file that go on at the same time: while one waits for a server or a frame, another has the processor. */
export const TOGETHER = { concurrency: 4 };

/** The mock, by the words of its command line; url is the link to it. */
export const startMock = (...options) => serve(process.env.VOLVIS_WEB, options);

export async function startBrowser() {
  return chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox", "--headless=new", "--enable-unsafe-swiftshader"] });
}

const idle = []; // pages that another test can have: a context costs most of a second of the processor

async function makePage(browser, { init, ...options }) {
  const context = await browser.newContext(options);
  context.setDefaultTimeout(PATIENCE_MS);
  const page = await context.newPage();
  page.on("pageerror", (error) => page.problems.push(error.message));
  page.on("console", (message) => { if (message.type() === "error" && !/WebSocket connection|net::ERR|403/.test(message.text())) page.problems.push(message.text()); });
  page.on("websocket", (socket) => socket.on("framesent", ({ payload }) => { if (typeof payload === "string") page.sent.push(JSON.parse(payload)); }));
  if (init) await page.addInitScript(init);
  // VOLVIS_PAGE: a folder of build.mjs, in the place of the page that is in the program, which need not be built again.
  for (const name of process.env.VOLVIS_PAGE ? ["app.js", "drawing.js", "worker.js", "app.css"] : [])
    await page.route(`**/${name}`, (route) => route.fulfill({ path: join(process.env.VOLVIS_PAGE, name) }));
  return page;
}

/**
 * A page whose errors are kept: a test ends by asking that there were none. What it says to the server is in page.sent.
 * Unless it is to be something special, it may be one that another test has closed: each server has a port of its own, and
 * with it what browsers keep. More than the named options make it special.
 */
export async function openPage(browser, url, { theme = "dark", viewport = { width: 1280, height: 720 }, reducedMotion = null, ...special } = {}) {
  const isSpecial = Object.keys(special).length > 0;
  const page = (!isSpecial && idle.pop()) || (await makePage(browser, { viewport, ...special }));
  Object.assign(page, { isSpecial, problems: [], sent: [] });
  await page.emulateMedia({ colorScheme: theme, reducedMotion });
  await page.setViewportSize(viewport);
  await page.goto(url);
  await page.waitForSelector(".connection-open");
  return page;
}

/** Of a page that a test has done with; one of a test that failed is closed with the browser. */
export async function closePage(page) {
  if (page.isSpecial) return page.context().close();
  await page.evaluate(() => localStorage.clear()); // a port may come again
  await page.goto("about:blank");
  await page.mouse.move(0, 0);
  return idle.push(page);
}

/** Polls; what: what is not so when it never comes. */
export async function until(condition, what) {
  for (const end = Date.now() + PATIENCE_MS; !(await condition()); await sleep(20)) assert.ok(Date.now() < end, what);
}

/** The page knows of nothing that will change the picture: all that was done is taken in, answered and seen. */
export async function waitForPicture(page) {
  await page.waitForSelector(".picture[aria-busy=false]").catch(async (error) => {
    const state = await page.locator(".overlay-state").first().textContent({ timeout: 1000 }).catch(() => "no word on it");
    throw new Error(`the picture is never finished: ${state}`, { cause: error });
  });
}

/** A click as quick as a hand's, however slow the machine is: what takes longer is no click. */
export async function clickAt(page, x, y) {
  const client = await page.context().newCDPSession(page);
  const at = { x, y, button: "left", clickCount: 1 };
  const t = Date.now() / 1000;
  await client.send("Input.dispatchMouseEvent", { type: "mousePressed", ...at, timestamp: t });
  await client.send("Input.dispatchMouseEvent", { type: "mouseReleased", ...at, timestamp: t + 0.05 });
  await client.detach();
}

/** For the page's init: timers of so many milliseconds run when window.runHeld() says so, and not before. */
export const holdTimers = (ms) => `{
  const { setTimeout: set, clearTimeout: clear } = window;
  const held = new Map();
  let n = -1;
  window.setTimeout = (run, after, ...more) => (after === ${ms} ? (held.set(--n, run), n) : set(run, after, ...more));
  window.clearTimeout = (id) => (held.delete(id) ? undefined : clear(id));
  window.runHeld = () => { const all = [...held.values()]; held.clear(); all.forEach((run) => run()); return all.length; };
}`;

/** The words are typed where the search has the focus, and what it found first is run. */
export async function search(page, words, { runs = true } = {}) {
  await page.keyboard.press("Control+k");
  await page.locator(".search-box input:focus").waitFor();
  await page.keyboard.type(words);
  if (!runs) return;
  await page.keyboard.press("Enter");
  await page.locator(".search-box").waitFor({ state: "detached" });
}

const RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"];
/** Those whose answer another theme may change: it has other colours, and nothing else. */
export const OF_COLOURS = { type: "rule", values: ["color-contrast", "link-in-text-block"] };

/** The rules of WCAG 2.2 A and AA that the page breaks, as lines. Evaluated in the page's own world, past its policy. */
export async function violations(page, runOnly = RULES) {
  const moves = await page.evaluate(() => document.getAnimations().map((a) => `${a.constructor.name} of ${a.effect?.target?.className}`));
  assert.deepEqual(moves, [], "colours are on their way: such tests open their pages with reduced motion");
  const client = await page.context().newCDPSession(page);
  const { result: there } = await client.send("Runtime.evaluate", { expression: "typeof axe", returnByValue: true });
  if (there.value === "undefined") await client.send("Runtime.evaluate", { expression: axeSource });
  const { result } = await client.send("Runtime.evaluate", {
    expression: `axe.run(document, { runOnly: ${JSON.stringify(runOnly)}, resultTypes: ["violations"] })
      .then((r) => JSON.stringify(r.violations.map((v) => v.id + ": " + v.nodes.map((n) => n.target.join(" ") + " (" + (n.any[0]?.message ?? n.all[0]?.message ?? n.none[0]?.message ?? "") + ")").slice(0, 4).join(" | "))))`,
    awaitPromise: true, returnByValue: true,
  });
  await client.detach();
  return JSON.parse(result.value);
}
