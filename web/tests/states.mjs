// The states of the page that are looked at: how one gets there from a fresh page. The server's jobs go on until they are cancelled.
import { clickAt, search } from "./browser.mjs";

const select = (page, name) => page.locator(".tree-name", { hasText: name }).click();
async function gaussian(page) {
  await page.locator(".component", { hasText: "Filter" }).click();
  await page.getByRole("button", { name: /^Gaussian/ }).click();
  await page.locator("[data-preview]").first().waitFor();
}
/** Of the World that `options` ask for: its chain of three steps, the last of which is open. */
async function chain(page) {
  await page.locator(".tree-name", { hasText: "body" }).click();
  await page.locator(".step-off").waitFor();
}
const layout = async (page, presses) => {
  await page.locator("[data-viewport]").focus();
  for (let i = 0; i < presses; i++) await page.keyboard.press("v");
};

/** The room with one of every sort of tool used on slices. */
async function measured(page) {
  await layout(page, 2);
  await page.locator("[data-slice=axial][data-final]").waitFor();
  await page.getByRole("button", { name: "Measurement room" }).click();
  const use = async (tool, plane, ...places) => {
    await page.locator(".measure-tool", { hasText: tool }).click();
    const n = await page.locator(".measure-table tbody tr").count();
    for (const [x, y] of places) {
      const box = await page.locator(`[data-slice=${plane}] .slice-area`).boundingBox();
      await page.mouse.click(box.x + x * box.width, box.y + y * box.height);
    }
    await page.locator(".measure-table tbody tr").nth(n).waitFor();
    await page.keyboard.press("Escape");
  };
  await use(/^Distance$/, "axial", [0.3, 0.4], [0.7, 0.5]);
  await use(/^Angle$/, "coronal", [0.35, 0.6], [0.5, 0.4], [0.65, 0.6]);
  await use(/^Profile$/, "sagittal", [0.3, 0.5], [0.7, 0.5]);
}

export const states = [
  { name: "volume", go: async () => {} },
  { name: "transfer-points", go: async (page) => { await page.getByRole("tab", { name: "Points" }).click(); await page.getByRole("slider", { name: /^Opacity point 2/ }).focus(); } },
  { name: "colour-maps", go: async (page) => { await page.getByRole("tab", { name: "Colour maps" }).click(); } },
  { name: "volume-lower", go: async (page) => {
    for (const group of ["Place", "Shading", "Cut planes"]) await page.getByRole("button", { name: new RegExp(`^${group}`) }).first().click();
    await page.getByRole("button", { name: "Add a cut plane", exact: true }).last().click();
    await page.getByRole("group", { name: "cut plane 1" }).scrollIntoViewIfNeeded();
  } },
  { name: "light", go: (page) => select(page, "key") },
  { name: "world", go: (page) => select(page, "World") },
  { name: "camera", go: (page) => select(page, "Camera") },
  { name: "rendering", go: (page) => select(page, "Rendering") },
  { name: "two-viewports", go: async (page) => { await layout(page, 1); await page.locator(".rendering .dot-final").waitFor(); } },
  { name: "slices", go: async (page) => { await layout(page, 2); await page.locator("[data-slice=sagittal][data-final] .cross-hair").waitFor(); } },
  { name: "own-drawing", go: async (page) => {
    await page.getByLabel("Drawing while the Navigator moves").selectOption("reduced");
    await page.getByRole("button", { name: "The page also draws at rest" }).click();
    await page.getByText("drawn by the page").waitFor();
  } },
  { name: "menu", go: async (page) => { await page.locator(".component", { hasText: "Filter" }).click(); await page.locator(".filter-entry").first().waitFor(); } },
  { name: "search", go: async (page) => { await page.keyboard.press("Control+k"); await page.waitForSelector(".search-list"); } },
  { name: "search-words", go: async (page) => { await search(page, "opac", { runs: false }); await page.locator(".search-row[aria-selected=true]", { hasText: /opac/i }).waitFor(); } },
  { name: "help", go: async (page) => { await page.getByRole("button", { name: "Keys and gestures" }).click(); await page.locator("dialog[open]").waitFor(); } },
  { name: "sessions", go: async (page) => { await page.getByRole("button", { name: "connected" }).click(); await page.locator("dialog[open]").waitFor(); } },
  { name: "open", go: async (page) => { await page.getByRole("button", { name: "Open a file", exact: true }).first().click(); await page.getByText("head.nii.gz").click(); } },
  { name: "save", go: async (page) => { await page.getByRole("button", { name: "Save the scene" }).click(); await page.getByText("scans").waitFor(); } },
  { name: "save-picture", go: async (page) => { await page.getByRole("button", { name: "Save a picture" }).click(); await page.locator("dialog[open]").waitFor(); } },
  { name: "operation", go: gaussian },
  { name: "operation-pointed-at", go: async (page) => { await gaussian(page); await page.getByRole("button", { name: "Apply" }).hover(); } },
  { name: "operation-slices", go: async (page) => {
    await layout(page, 2);
    await page.locator("[data-slice=sagittal][data-final] .cross-hair").waitFor();
    await search(page, "gaussian");
    await page.locator("[data-preview=sagittal]").waitFor();
  } },
  { name: "operation-whole", go: async (page) => { await search(page, "components"); await page.getByText("works on all samples at once").waitFor(); } },
  { name: "pipeline", options: ["--made"], go: chain },
  { name: "pipeline-failed", options: ["--made"], go: async (page) => { await chain(page); await page.getByRole("textbox", { name: "Range", exact: true }).fill(""); await page.keyboard.press("Enter"); await page.locator(".step-failed").waitFor(); } },
  { name: "pipeline-insert", options: ["--made"], go: async (page) => { await chain(page); await page.getByRole("button", { name: "Add a step" }).click(); await page.locator(".filter-entry").first().waitFor(); } },
  { name: "job", go: async (page) => {
    await gaussian(page);
    await page.getByRole("button", { name: "Apply" }).click();
    await page.waitForSelector(".job");
  } },
  { name: "picked", go: async (page) => {
    const box = await page.locator("[data-viewport]").boundingBox();
    await clickAt(page, box.x + box.width / 2, box.y + box.height / 2);
    await page.waitForSelector(".probe");
  } },
  { name: "measure-profile", go: measured },
  { name: "measure-drawing", go: async (page) => {
    await measured(page);
    await page.locator(".measure-tool", { hasText: /^Polyline$/ }).click();
    const box = await page.locator("[data-slice=axial] .slice-area").boundingBox();
    for (const [x, y] of [[0.25, 0.6], [0.4, 0.75], [0.6, 0.7]]) await page.mouse.click(box.x + x * box.width, box.y + y * box.height);
    await page.mouse.move(box.x + 0.75 * box.width, box.y + 0.6 * box.height);
    await page.locator(".measure-live").waitFor();
  } },
  { name: "measure-histogram", go: async (page) => {
    await page.getByRole("button", { name: "Measurement room" }).click();
    await page.locator(".measure-tool", { hasText: "Whole volume" }).click();
    await page.locator(".measure-steps").waitFor();
  } },
  { name: "measure-empty", go: async (page) => { await page.getByRole("button", { name: "Measurement room" }).click(); await page.locator(".measure-room").waitFor(); } },
  { name: "refused", go: async (page) => {
    await select(page, "key");
    await page.getByRole("textbox", { name: "Intensity" }).fill("nonsense");
    await page.keyboard.press("Enter");
    await page.waitForSelector(".row-error");
  } },
  { name: "notice", go: async (page) => {
    await page.keyboard.press("Control+o");
    await page.getByRole("textbox", { name: "Path" }).fill("notes.txt");
    await page.keyboard.press("Enter");
    await page.waitForSelector(".row-error");
  } },
];
