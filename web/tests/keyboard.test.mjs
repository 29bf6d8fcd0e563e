// The program with a real head, by keys alone: no mouse is touched from the first file to the saved scene.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { join } from "node:path";
import { describe, test } from "node:test";
import { search, TOGETHER, until, waitForPicture } from "./browser.mjs";
import { back, changed, file, folder, QUICK, seen, skip, withProgram } from "./served.mjs";

const focused = (page) => page.evaluate(() => {
  const e = document.activeElement;
  return `${e?.getAttribute("role") ?? e?.tagName.toLowerCase()} ${e?.getAttribute("aria-label") ?? document.getElementById(e?.getAttribute("aria-labelledby") ?? "")?.textContent ?? e?.labels?.[0]?.textContent?.trim() ?? (e?.textContent?.trim() || e?.getAttribute("placeholder") || "")}`;
});

/** Tab until what has the focus fits. Everything that has it on the way must show that it does. */
async function tabTo(page, pattern, { back = false, most = 200 } = {}) {
  for (let i = 0; i < most; i++) {
    if (pattern.test(await focused(page))) return;
    await page.keyboard.press(back ? "Shift+Tab" : "Tab");
    const shown = await page.evaluate(() => {
      const e = document.activeElement;
      if (!e || e === document.body) return true;
      const parts = [e, e.parentElement, ...e.querySelectorAll("*")]; // a field shows it around its entry, a point of a curve or of a measurement on its dot
      return parts.some((part) => { const style = getComputedStyle(part); return style.outlineStyle !== "none" || style.boxShadow !== "none" || part.matches(".plot-hit, .measure-hit"); });
    });
    assert.ok(shown, `the focus cannot be seen on: ${await focused(page)}`);
  }
  assert.fail(`no way by Tab to ${pattern}; the last is: ${await focused(page)}`);
}

describe("by keys alone", TOGETHER, () => {
  test("a file is opened, turned, given another transfer function, cut, filtered, taken back and saved by keys", { skip }, () => withProgram([], async (page) => {
    await page.getByRole("heading", { name: "See inside your data" }).waitFor();
    await page.keyboard.press("Control+o");
    await page.locator("dialog[open]").waitFor();
    await tabTo(page, /^input Path/);
    await page.keyboard.type(file);
    await page.keyboard.press("Enter");
    const first = await seen(page);

    await tabTo(page, /^application Navigator/);
    for (let i = 0; i < 6; i++) await page.keyboard.press("ArrowLeft");
    const turned = await changed(page, first, 30, "arrows do not turn");
    await page.keyboard.press("+");
    const nearer = await changed(page, turned, 35, "plus does not come nearer");

    await tabTo(page, /^slider Opacity point 3/);
    for (let i = 0; i < 5; i++) await page.keyboard.press("Shift+ArrowUp");
    const denser = await changed(page, nearer, 45, "the transfer function did nothing");

    await search(page, "add a cut plane");
    const cut = await changed(page, denser, 30, "it was not cut");

    await search(page, "gaussian");
    await page.getByRole("textbox", { name: "Sigma", exact: true }).waitFor();
    await tabTo(page, /^input Sigma$/);
    await page.keyboard.press("Control+a");
    await page.keyboard.type("3mm");
    await tabTo(page, /^button Apply$/);
    await page.keyboard.press("Enter");
    await page.locator(".tree-name", { hasText: "gaussian" }).waitFor();
    await changed(page, cut, 45, "it was not smoothed");

    await page.keyboard.press("Control+z");
    await page.locator(".tree-name", { hasText: "gaussian" }).waitFor({ state: "detached" });
    await back(page, cut, "undo shows another picture");

    await page.keyboard.press("Control+s");
    await page.locator("dialog[open]").waitFor();
    await tabTo(page, /^input Name/);
    await page.keyboard.press("Control+a");
    await page.keyboard.type(join(folder, "keys.vv.json"));
    await page.keyboard.press("Enter");
    await page.locator("dialog").waitFor({ state: "detached" });
    assert.ok(existsSync(join(folder, "keys.vv.json")));
  }));

  test("a filter is chosen and set, and a pipeline is edited, by keys", { skip }, () => withProgram(QUICK, async (page) => {
    const steps = () => page.locator(".step:not(.step-source) .step-title").allTextContents();
    await waitForPicture(page);
    await tabTo(page, /^button Filter$/);
    await page.keyboard.press("Enter");
    await page.locator(".filter-menu input:focus").waitFor();
    await page.keyboard.type("thresh");
    await page.keyboard.press("ArrowDown");
    await until(async () => /^button Threshold/.test(await focused(page)), "ArrowDown does not come to the first entry");
    await page.keyboard.press("Enter");
    await page.locator(".filter-panel").waitFor();
    await tabTo(page, /^select Method$/);
    await page.keyboard.press("ArrowDown");
    await until(() => page.sent.findLast((m) => m.type === "preview")?.parameters.method === "otsu", "the method is not chosen");
    await tabTo(page, /^button Apply$/);
    await page.keyboard.press("Enter");
    await page.locator(".step-title", { hasText: "Threshold" }).waitFor();

    await tabTo(page, /^button Add a step$/);
    await page.keyboard.press("Enter");
    await page.locator(".filter-menu input:focus").waitFor();
    await page.keyboard.type("dilate");
    await page.keyboard.press("Enter");
    await page.locator(".filter-panel h2", { hasText: "Dilate" }).waitFor();
    await tabTo(page, /^button Apply$/);
    await page.keyboard.press("Enter");
    await until(async () => String(await steps()) === "Threshold,Dilate", "there are not two steps");

    await tabTo(page, /^button Dilate/);
    await page.keyboard.press("Alt+ArrowUp");
    await until(async () => String(await steps()) === "Dilate,Threshold", "Alt and an arrow do not move the step");
    await until(async () => /^button Dilate/.test(await focused(page)), "the focus does not go with the step");
    await page.keyboard.press("Alt+ArrowDown");
    await until(async () => String(await steps()) === "Threshold,Dilate", "it does not move back");
    await tabTo(page, /^switch Dilate is applied$/);
    await page.keyboard.press("Space");
    await page.locator(".step-off", { hasText: "Dilate" }).waitFor();
    await tabTo(page, /^button Copy as command$/);
    await page.evaluate(() => { navigator.clipboard.writeText = async (text) => { window.copied = text; }; });
    await page.keyboard.press("Enter");
    await until(() => page.evaluate(() => window.copied?.startsWith("volvis pipe ")), "the pipeline is not copied");
    assert.match(await page.evaluate(() => window.copied), /'threshold --method=otsu' -o /);
    await tabTo(page, /^button Remove Dilate$/, { back: true });
    await page.keyboard.press("Enter");
    await until(async () => String(await steps()) === "Threshold", "the step is not removed");
    await until(async () => !/^body/.test(await focused(page)), "the focus is lost with the step");
  }));

  test("places are measured, and the table is sorted, renamed and emptied, by keys", { skip }, () => withProgram(QUICK, async (page) => {
    const names = () => page.locator(".measure-name").allTextContents();
    const measured = (n) => page.locator(".measure-table tbody tr").nth(n - 1).waitFor();
    await waitForPicture(page);
    await tabTo(page, /^application Navigator/);
    for (const key of ["v", "v", "m"]) await page.keyboard.press(key);
    await page.locator("[data-slice=axial][data-final] .cross-hair").waitFor();
    await tabTo(page, /^button Point$/);
    await page.keyboard.press("ArrowRight");
    await until(async () => /^button Distance$/.test(await focused(page)), "an arrow does not come to the next tool");
    await page.keyboard.press("Enter");
    const go = async (pattern, ...keys) => {
      await tabTo(page, pattern);
      for (const key of keys) await page.keyboard.press(key);
    };
    await go(/^application Axial slice/, "Space");
    await until(async () => (await page.locator("[data-slice=axial] g[aria-hidden] .measure-dot").count()) === 1, "no point is placed");
    await go(/^application Sagittal slice/, "PageUp");
    await until(() => page.sent.some((m) => m.edits?.[0]?.path === "cross_hair"), "the cross-hair does not move");
    await go(/^application Axial slice/, "Space");
    await measured(1);
    await page.keyboard.press("Escape");
    await go(/^button Point$/, "Enter");
    await go(/^application Axial slice/, "Space");
    await measured(2);
    await page.keyboard.press("Escape");

    await go(/^button Name$/, "Enter", "Enter");
    await until(async () => String(await names()) === "point,distance", "the table is not sorted");
    await go(/^button point$/, "F2");
    await page.locator(".measure-rename:focus").waitFor();
    await page.keyboard.type("here");
    await page.keyboard.press("Enter");
    await until(async () => /^button .*here/.test(await focused(page)), "the focus is not back on the name");
    await go(/^button Hide /, "Enter");
    await page.locator(".measure-hidden").waitFor();
    await go(/^button distance$/);
    await page.keyboard.press("Delete");
    await until(async () => (await names()).length === 1, "it is not removed");
    await until(async () => /here$/.test(await focused(page)), "the focus does not go to the next name");
    await page.keyboard.press("Delete");
    await until(async () => (await names()).length === 0, "the last is not removed");
  }));

  test("Tab goes round the whole page and comes back, forwards and backwards", { skip }, () => withProgram(QUICK, async (page) => {
    await waitForPicture(page);
    await page.getByRole("slider", { name: /^Opacity point/ }).first().waitFor();
    await tabTo(page, /^application Navigator/);
    await page.evaluate(() => { window.home = document.activeElement; });
    for (const key of ["Tab", "Shift+Tab"]) {
      const names = new Set();
      let isHome = false;
      for (let i = 0; i < 400 && !isHome; i++) {
        await page.keyboard.press(key);
        names.add(await focused(page));
        isHome = await page.evaluate(() => document.activeElement === window.home);
      }
      assert.ok(isHome, `${key} does not come back to the Navigator: ${[...names].join(" | ")}`);
      for (const wanted of [/^application Navigator/, /^slider Opacity point/, /Undo|Redo|Open/, /^button .*theme/i])
        assert.ok([...names].some((name) => wanted.test(name)), `${key} never reaches ${wanted}: ${[...names].join(" | ")}`);
    }
  }));

  test("a dialog keeps the focus, Escape closes it, and the focus is back where it was", { skip }, () => withProgram(QUICK, async (page) => {
    await waitForPicture(page);
    await tabTo(page, /^application Navigator/);
    for (const key of ["Control+o", "Control+s", "Control+k", "F12", "?"]) {
      await page.keyboard.press(key);
      await page.locator("dialog[open]").waitFor();
      for (let i = 0; i < 40; i++) {
        await page.keyboard.press("Tab");
        assert.ok(await page.evaluate(() => document.activeElement === document.body || !!document.activeElement?.closest("dialog")), `${key}: Tab leaves the dialog for ${await focused(page)}`);
      }
      await page.keyboard.press("Escape");
      await page.locator("dialog[open]").waitFor({ state: "detached" });
      await until(async () => /^application Navigator/.test(await focused(page)), `after ${key} and Escape the focus is not back`);
    }
  }));
});
