// What the tests in the browser share: the mock server, Chromium, axe.
import { spawn } from "node:child_process";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { readFileSync } from "node:fs";
import { chromium } from "playwright-core";

const here = dirname(fileURLToPath(import.meta.url));
const axeSource = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

/** Starts the mock; url is the link that it prints. */
export async function startMock(...options) {
  const child = spawn(process.execPath, [join(here, "../mock/mock.mjs"), process.env.VOLVIS_WEB, ...options], { stdio: ["ignore", "pipe", "inherit"] });
  const url = await new Promise((resolve, reject) => {
    child.stdout.once("data", (data) => resolve(String(data).trim()));
    child.once("exit", () => reject(new Error("the mock server ended")));
  });
  return { url, stop: () => child.kill() };
}

export async function startBrowser() {
  return chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox", "--headless=new", "--enable-unsafe-swiftshader"] });
}

/** A page whose errors are kept: a test ends by asking that there were none. */
export async function openPage(browser, url, { theme = "dark", ...options } = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 720 }, colorScheme: theme, ...options });
  const page = await context.newPage();
  page.problems = [];
  page.on("pageerror", (error) => page.problems.push(error.message));
  page.on("console", (message) => { if (message.type() === "error" && !/WebSocket connection|net::ERR|403/.test(message.text())) page.problems.push(message.text()); });
  // VOLVIS_PAGE: a folder of build.mjs, in the place of the page that is in the program, which need not be built again.
  for (const name of process.env.VOLVIS_PAGE ? ["app.js", "drawing.js", "worker.js", "app.css"] : [])
    await page.route(`**/${name}`, (route) => route.fulfill({ path: join(process.env.VOLVIS_PAGE, name) }));
  await page.goto(url);
  await page.waitForSelector(".connection-open");
  return page;
}

export async function waitForPicture(page) {
  await page.waitForSelector(".dot-final", { timeout: 20000 });
}

/** The rules of WCAG 2.2 A and AA that the page breaks, as lines. Evaluated in the page's own world, past its policy. */
export async function violations(page) {
  const client = await page.context().newCDPSession(page);
  await client.send("Runtime.evaluate", { expression: axeSource });
  const { result } = await client.send("Runtime.evaluate", {
    expression: `axe.run(document, { runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"], resultTypes: ["violations"] })
      .then((r) => JSON.stringify(r.violations.map((v) => v.id + ": " + v.nodes.map((n) => n.target.join(" ") + " (" + (n.any[0]?.message ?? n.all[0]?.message ?? n.none[0]?.message ?? "") + ")").slice(0, 4).join(" | "))))`,
    awaitPromise: true, returnByValue: true,
  });
  return JSON.parse(result.value);
}
