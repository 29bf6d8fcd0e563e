// The states of the page that are looked at: how one gets there from a fresh page.
export const states = [
  { name: "volume", go: async () => {} },
  { name: "transfer-points", go: async (page) => { await page.getByRole("tab", { name: "Points" }).click(); await page.getByRole("slider", { name: /^Opacity point 2/ }).focus(); } },
  { name: "colour-maps", go: async (page) => { await page.getByRole("tab", { name: "Colour maps" }).click(); } },
  { name: "volume-lower", go: async (page) => {
    for (const group of ["Place", "Shading", "Cut planes"]) await page.getByRole("button", { name: new RegExp(`^${group}`) }).first().click();
    await page.getByRole("button", { name: "Add a cut plane", exact: true }).last().click();
    await page.getByRole("group", { name: "cut plane 1" }).scrollIntoViewIfNeeded();
  } },
  { name: "light", go: async (page) => { await page.locator(".tree-name", { hasText: "key" }).click(); } },
  { name: "world", go: async (page) => { await page.locator(".tree-name", { hasText: "World" }).click(); } },
  { name: "camera", go: async (page) => { await page.locator(".tree-name", { hasText: "Camera" }).click(); } },
  { name: "rendering", go: async (page) => { await page.locator(".tree-name", { hasText: "Rendering" }).click(); } },
  { name: "two-viewports", go: async (page) => { await page.locator("[data-viewport]").focus(); await page.keyboard.press("v"); await page.locator(".rendering .dot-final").waitFor({ timeout: 20000 }); } },
  { name: "slices", go: async (page) => { await page.locator("[data-viewport]").focus(); await page.keyboard.press("v"); await page.keyboard.press("v"); await page.locator("[data-slice=sagittal][data-final] .cross-hair").waitFor({ timeout: 20000 }); } },
  { name: "own-drawing", go: async (page) => {
    await page.getByLabel("Drawing while the Navigator moves").selectOption("reduced");
    await page.getByRole("button", { name: "The page draws at rest too" }).click();
    await page.getByText("drawn by the page").waitFor();
  } },
  { name: "menu", go: async (page) => { await page.locator(".component-menu summary").first().click(); } },
  { name: "search", go: async (page) => { await page.keyboard.press("Control+k"); await page.waitForSelector(".search-list"); } },
  { name: "search-words", go: async (page) => { await page.keyboard.press("Control+k"); await page.keyboard.type("opac"); } },
  { name: "help", go: async (page) => { await page.getByRole("button", { name: "Keys and gestures" }).click(); } },
  { name: "open", go: async (page) => { await page.getByRole("button", { name: "Open a file", exact: true }).first().click(); await page.getByText("head.nii.gz").click(); } },
  { name: "save", go: async (page) => { await page.getByRole("button", { name: "Save the scene" }).click(); await page.getByText("scans").waitFor(); } },
  { name: "save-picture", go: async (page) => { await page.getByRole("button", { name: "Save a picture" }).click(); } },
  { name: "operation", go: async (page) => { await page.locator(".component-menu summary").first().click(); await page.getByRole("button", { name: "Gaussian" }).click(); } },
  { name: "job", go: async (page) => {
    await page.locator(".component-menu summary").first().click();
    await page.getByRole("button", { name: "Gaussian" }).click();
    await page.getByRole("button", { name: "Run" }).click();
    await page.waitForSelector(".job");
  } },
  { name: "picked", go: async (page) => { await page.locator("[data-viewport]").click(); await page.waitForSelector(".probe"); } },
  { name: "refused", go: async (page) => {
    await page.locator(".tree-name", { hasText: "key" }).click();
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
