// No state of the page breaks a rule of WCAG 2.2 A or AA that axe-core can check, in both themes, at three sizes.
import assert from "node:assert/strict";
import { after, before, describe, test } from "node:test";
import { closePage, OF_COLOURS, openPage, startBrowser, startMock, TOGETHER, violations, waitForPicture } from "./browser.mjs";
import { states } from "./states.mjs";

let browser;
before(async () => { browser = await startBrowser(); });
after(() => browser.close());

async function check(options, go, viewport = { width: 1280, height: 720 }) {
  const mock = await startMock("--quick", "--held", ...options);
  try {
    const page = await openPage(browser, mock.url, { theme: "dark", viewport, reducedMotion: "reduce" });
    if (!options.length) await waitForPicture(page);
    await go(page, mock);
    assert.deepEqual(await violations(page), [], "dark");
    await page.emulateMedia({ colorScheme: "light" });
    await page.locator("[data-theme=light]").waitFor();
    assert.deepEqual(await violations(page, OF_COLOURS), [], "light");
    assert.deepEqual(page.problems, []);
    await closePage(page);
  } finally {
    mock.stop();
  }
}

describe("in both themes no rule is broken by", TOGETHER, () => {
  test("the start page", () => check(["--empty"], async () => {}));
  test("a lost connection", () => check([], async (page, mock) => { mock.down(); await page.waitForSelector(".banner"); }));
  for (const state of states) test(state.name, () => check(state.options ?? [], state.go));
  test("a narrow page with its inspector open", () => check([], async (page) => {
    await page.getByRole("button", { name: "Show or hide the inspector" }).click();
    await page.locator(".inspector").waitFor();
  }, { width: 640, height: 360 }));
});
