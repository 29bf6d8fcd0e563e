// No state of the page breaks a rule of WCAG 2.2 A or AA that axe-core can check, in both themes, at three sizes.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { openPage, startBrowser, startMock, violations, waitForPicture } from "./browser.mjs";
import { states } from "./states.mjs";

let browser;
before(async () => { browser = await startBrowser(); });
after(() => browser.close());

async function check(name, theme, options, go, viewport = { width: 1280, height: 720 }) {
  const mock = await startMock("--quick", ...options);
  try {
    const page = await openPage(browser, mock.url, { theme, viewport, reducedMotion: "reduce" });
    if (!options.length) await waitForPicture(page);
    await go(page, mock);
    assert.deepEqual(await violations(page), [], `${name}, ${theme}`);
    assert.deepEqual(page.problems, [], `${name}, ${theme}`);
    await page.context().close();
  } finally {
    mock.stop();
  }
}

for (const theme of ["dark", "light"]) {
  test(`the start page, ${theme}`, () => check("start", theme, ["--empty"], async () => {}));
  test(`a lost connection, ${theme}`, () => check("lost", theme, [], async (page, mock) => { mock.stop(); await page.waitForSelector(".banner"); }));
  for (const state of states) test(`${state.name}, ${theme}`, () => check(state.name, theme, [], state.go));
}
test("a narrow page with its inspector open", () => check("narrow", "dark", [], async (page) => {
  await page.getByRole("button", { name: "Show or hide the inspector" }).click();
}, { width: 640, height: 360 }));
