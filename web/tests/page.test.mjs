// What people do with the page, against the mock server.
import assert from "node:assert/strict";
import { after, before, describe, test } from "node:test";
import { closePage, holdTimers, openPage, PATIENCE_MS, search, startBrowser, startMock, TOGETHER, until, waitForPicture } from "./browser.mjs";

let browser;
before(async () => { browser = await startBrowser(); });
after(() => browser.close());

/** A page and a mock of its own. */
async function withPage(options, act, pageOptions = {}) {
  const mock = await startMock("--quick", ...options);
  try {
    const page = await openPage(browser, mock.url, pageOptions);
    if (!options.includes("--empty")) await waitForPicture(page);
    await act(page, mock);
    assert.deepEqual(page.problems, []);
    await closePage(page);
  } finally {
    mock.stop();
  }
}

const linesOf = (page) => page.sent.filter((m) => m.type === "events" && m.lines).flatMap((m) => m.lines.split("\n"));
const editsOf = (page) => page.sent.filter((m) => m.type === "edit");

const framesOf = (page) => page.sent.filter((m) => m.type === "frames").map((m) => m.wanted);
const chooser = (page) => page.getByLabel("Drawing while the Navigator moves");

function withoutWebGL() {
  const get = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, ...more) { return kind.startsWith("webgl") ? null : get.call(this, kind, ...more); };
}

async function showSlices(page) {
  await page.locator("[data-viewport]").focus();
  await page.keyboard.press("v");
  await page.keyboard.press("v");
  for (const plane of ["axial", "coronal", "sagittal"]) await page.locator(`[data-slice=${plane}][data-final] .cross-hair`).waitFor();
}
const hairs = (page) => editsOf(page).filter((m) => m.edits[0].path === "cross_hair");

describe("the page", TOGETHER, () => {
  test("the page draws by itself while the picture turns, and hands over to the server's at rest", () => withPage([], async (page) => {
    await chooser(page).selectOption("reduced");
    await until(() => framesOf(page).length === 1, "the server goes on to send frames that move");
    assert.deepEqual(framesOf(page), ["resting"]);
    await page.evaluate(() => { // it may be over before anybody asks
      const seen = (window.seen = new Set());
      const look = () => { if (document.querySelector(".own-drawing").style.visibility === "visible") seen.add(document.querySelector(".overlay-state").textContent); };
      new MutationObserver(look).observe(document.querySelector(".centre"), { subtree: true, childList: true, characterData: true, attributes: true });
    });
    await page.locator("[data-viewport]").focus();
    await page.keyboard.press("ArrowLeft");
    await until(() => page.evaluate(() => window.seen.has("Reduced surface · drawn by the page")), "the page does not draw what turns");
    await waitForPicture(page);
    await page.locator(".own-drawing").waitFor({ state: "hidden" });
    await page.getByRole("button", { name: "The page also draws at rest" }).click();
    await page.locator(".own-drawing").waitFor({ state: "visible" });
    await page.reload();
    await page.locator(".own-drawing").waitFor({ state: "visible" });
    assert.equal(await chooser(page).inputValue(), "reduced");
    await chooser(page).selectOption("server");
    await page.locator(".own-drawing").waitFor({ state: "hidden" });
    await until(() => framesOf(page).at(-1) === "all", "frames of the server are not asked for again");
    await page.locator("[data-viewport]").focus();
    await page.keyboard.press("d");
    await until(async () => (await chooser(page).inputValue()) === "reduced", "D does not go on to the next");
  }));

  test("a browser without WebGL is told once, and the server's frames go on", () => withPage([], async (page) => {
    await chooser(page).selectOption("reduced");
    await page.getByText("This browser has no WebGL 2").waitFor();
    await page.locator("[data-viewport]").focus();
    await page.keyboard.press("ArrowLeft");
    await waitForPicture(page);
    assert.deepEqual(framesOf(page), []);
    page.problems = page.problems.filter((text) => !text.startsWith("THREE.WebGLRenderer:")); // it says so in the console
  }, { init: withoutWebGL }));

  test("the page lost its graphics card: the server's frames go on, and its own when it is back", () => withPage([], async (page) => {
    await chooser(page).selectOption("reduced");
    await page.getByRole("button", { name: "The page also draws at rest" }).click();
    await page.locator(".own-drawing").waitFor({ state: "visible" });
    await page.evaluate(() => {
      window.lost = document.querySelector(".own-drawing").getContext("webgl2").getExtension("WEBGL_lose_context");
      window.lost.loseContext();
    });
    await page.getByText("The page has lost the graphics card").waitFor();
    await page.locator(".own-drawing").waitFor({ state: "hidden" });
    await until(() => framesOf(page).at(-1) === "all", "frames of the server are not asked for again");
    await page.evaluate(() => window.lost.restoreContext());
    await page.locator(".own-drawing").waitFor({ state: "visible" });
  }));

  test("the token leaves the address at once, and a reload needs it no more", () => withPage([], async (page) => {
    assert.equal(new URL(page.url()).hash, "");
    await page.reload();
    await page.waitForSelector(".connection-open");
  }));

  test("a wrong token is refused in a sentence", async () => {
    const mock = await startMock("--quick");
    const context = await browser.newContext();
    const page = await context.newPage();
    await page.goto(mock.url.replace("#mock", "#wrong"));
    await page.getByText("This link is no longer valid").waitFor({ timeout: PATIENCE_MS });
    await context.close();
    mock.stop();
  });

  test("a drag is sent as raw events, with the time running on, at most one message a frame", () => withPage([], async (page) => {
    const box = await page.locator("[data-viewport]").boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width / 2 + 120, box.y + box.height / 2 - 40, { steps: 30 });
    await page.mouse.up();
    await until(() => linesOf(page).some((line) => /left up/.test(line)), "no button up");
    const lines = linesOf(page);
    const times = lines.map((line) => Number(line.split(" ")[0]));
    assert.deepEqual(times, [...times].sort((a, b) => a - b));
    const down = lines.findIndex((line) => /mouse button left down/.test(line));
    assert.match(lines[down - 2], /mouse axis x 0$/);
    const last = lines.filter((line) => /mouse axis x/.test(line)).at(-1);
    assert.ok(Math.abs(Number(last.split(" ")[4]) - 120 / (Math.min(box.width, box.height) / 2)) < 0.01, last);
  }));

  test("each frame is acknowledged", () => withPage([], async (page) => {
    const acks = () => page.sent.filter((m) => m.type === "ack").map((m) => m.frame);
    await until(() => acks().length >= 3, "three frames, from coarse to fine, are not acknowledged");
    assert.deepEqual(acks(), [...new Set(acks())]);
  }));

  test("keys in the picture go to the server, those of the page stay", () => withPage([], async (page) => {
    await page.locator("[data-viewport]").focus();
    await page.keyboard.press("ArrowLeft");
    await page.keyboard.press("Shift+Digit1");
    await until(() => linesOf(page).some((line) => /Shift up/.test(line)), "no key");
    const lines = linesOf(page).map((line) => line.replace(/^\d+ /, ""));
    assert.deepEqual(lines, [
      "keyboard key ArrowLeft down", "keyboard key ArrowLeft up", "keyboard key Shift down", "keyboard key Digit1 down", "keyboard key Digit1 up", "keyboard key Shift up",
    ]);
    await page.keyboard.press("h");
    await page.getByRole("heading", { name: "Keys and gestures" }).waitFor();
    await page.keyboard.press("Escape");
    await page.locator("dialog").waitFor({ state: "detached" });
    await page.locator("[data-viewport]:focus").waitFor();
  }));

  test("what is held is let go when the window loses the focus", () => withPage([], async (page) => {
    const viewport = page.locator("[data-viewport]");
    await viewport.focus();
    await page.keyboard.down("Shift");
    await page.keyboard.down("ArrowUp");
    await page.evaluate("window.dispatchEvent(new Event('blur'))");
    await until(() => linesOf(page).some((line) => /keyboard lost/.test(line)), "not lost");
    for (const key of ["Shift", "ArrowUp"]) await page.keyboard.up(key);
  }));

  test("two fingers are two touches", () => withPage([], async (page) => {
    const client = await page.context().newCDPSession(page);
    const touch = (type, ...points) => client.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
    await touch("touchStart", [500, 300], [700, 400]);
    await touch("touchMove", [480, 280], [720, 420]);
    await touch("touchEnd");
    await until(() => linesOf(page).filter((line) => /touch \d+ end/.test(line)).length === 2, "no end of touches");
    const ids = new Set(linesOf(page).filter((line) => /touch touch/.test(line)).map((line) => line.split(" ")[3]));
    assert.equal(ids.size, 2);
  }, { hasTouch: true }));

  test("a drag of a point is one gesture, and keeps the length that opacities are for", () => withPage([], async (page) => {
    const point = page.getByRole("slider", { name: /^Opacity point 2/ });
    const box = await point.locator(".plot-dot").boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down();
    for (const [i, y] of [-10, -40].entries()) { // what moves within a frame of the screen is one motion
      await page.mouse.move(box.x + 20, box.y + y);
      await until(() => editsOf(page).length > i, "a motion sends no edit");
    }
    await page.mouse.up();
    const edits = editsOf(page);
    assert.equal(new Set(edits.map((m) => m.gesture)).size, 1);
    assert.deepEqual(edits[0].edits.map((e) => e.path), ["volumes.ring.segmentation.transfer.opacity", "volumes.ring.segmentation.transfer.opacity_length"]);
    assert.equal(edits[0].edits[1].value, 0.5);
    await waitForPicture(page);
    await page.getByRole("button", { name: /^Undo/, disabled: false }).waitFor();
    await page.keyboard.press("Control+z");
    await page.getByRole("button", { name: /^Undo/, disabled: true }).waitFor();
  }));

  test("points by keys: move, add, remove", () => withPage([], async (page) => {
    const point = page.getByRole("slider", { name: /^Opacity point 3/ });
    await point.focus();
    const before = Number(await point.getAttribute("aria-valuenow"));
    await page.keyboard.press("ArrowUp");
    await until(() => editsOf(page).length === 1, "no edit");
    assert.ok(Math.abs(editsOf(page)[0].edits[0].value[2][1] - before - 0.01) < 1e-9);
    await page.keyboard.press("Delete");
    await until(() => editsOf(page).length === 2, "nothing removed");
    assert.equal(editsOf(page)[1].edits[0].value.length, 3);
    await page.getByRole("tab", { name: "Points" }).click();
    await page.getByRole("button", { name: "Add an opacity point" }).click();
    await until(() => editsOf(page).length === 3, "nothing added");
    assert.equal(editsOf(page)[2].edits[0].value.length, 4);
  }));

  test("a preset takes away what would hide it, in one commit", () => withPage([], async (page) => {
    await page.getByRole("slider", { name: /^Opacity point 2/ }).focus();
    await page.keyboard.press("ArrowUp");
    await page.getByRole("button", { name: "Fog" }).click();
    await until(() => editsOf(page).length === 2, "no preset");
    assert.deepEqual(editsOf(page)[1].edits.map((e) => `${e.op} ${e.path.split(".").pop()}`), ["set preset", "unset opacity", "unset opacity_length"]);
  }));

  test("proposals have pictures of the data, and one is taken by keys in one commit", () => withPage([], async (page) => {
    const list = page.getByRole("list", { name: "Proposals" });
    const boundaries = list.getByRole("button", { name: "Boundaries" });
    await boundaries.locator("img").waitFor();
    assert.deepEqual(await list.getByRole("button").allInnerTexts(), ["Fitted", "Boundaries", "Outside", "Dense", "Bands"]);
    assert.equal(await list.getByRole("button", { name: "Fitted" }).getAttribute("aria-pressed"), "true");
    const isShown = () => boundaries.locator("img").evaluate((img) => img.complete && img.naturalWidth > 0);
    await until(isShown, "the policy does not let the picture in");
    await boundaries.focus();
    await page.keyboard.press("Enter");
    await until(() => editsOf(page).length === 1, "no edit");
    assert.deepEqual(editsOf(page)[0].edits, [{ op: "set", path: "volumes.ring.segmentation.transfer.preset", value: "boundaries" }]);
    await page.locator(".preset[aria-pressed=true]", { hasText: "Boundaries" }).waitFor();
    await page.keyboard.press("Control+z");
    await page.locator(".preset[aria-pressed=true]", { hasText: "Fitted" }).waitFor();
  }));

  test("a property by keys alone: search, type, undo", () => withPage([], async (page) => {
    await search(page, "specular");
    const focused = () => page.evaluate("document.activeElement?.getAttribute('aria-label') || document.activeElement?.id || ''");
    await until(async () => /specular/i.test(await focused()), "the property that was searched has not the focus");
    const field = page.getByRole("textbox", { name: "Specular" });
    await field.fill("0.6");
    await page.keyboard.press("Enter");
    await until(() => editsOf(page).length === 1, "no edit");
    assert.deepEqual(editsOf(page)[0].edits, [{ op: "set", path: "volumes.ring.shading.specular", value: 0.6 }]);
    await page.getByRole("button", { name: "Specular: back to the default" }).click();
    await until(() => editsOf(page).length === 2, "no reset");
    assert.deepEqual(editsOf(page)[1].edits, [{ op: "unset", path: "volumes.ring.shading.specular" }]);
  }));

  test("a refusal stands at its place", () => withPage([], async (page) => {
    await page.locator(".tree-name", { hasText: "key" }).click();
    await page.getByRole("textbox", { name: "Intensity" }).fill("nonsense");
    await page.keyboard.press("Enter");
    await page.getByRole("alert").getByText("is not understood").waitFor();
    assert.equal(await page.getByRole("textbox", { name: "Intensity" }).getAttribute("aria-invalid"), "true");
  }));

  test("the tree by keys: move, hide, remove", () => withPage([], async (page) => {
    await page.locator(".tree-name", { hasText: "key" }).click();
    await page.keyboard.press("Space");
    await until(() => editsOf(page).length === 1, "not hidden");
    assert.deepEqual(editsOf(page)[0].edits, [{ op: "set", path: "lights.key.on", value: false }]);
    await page.keyboard.press("ArrowDown");
    await page.keyboard.press("Delete");
    await until(() => editsOf(page).length === 2, "not removed");
    assert.deepEqual(editsOf(page)[1].edits, [{ op: "remove", path: "lights.fill" }]);
  }));

  test("an operation runs, tells how far it is, and is cancelled", () => withPage(["--held"], async (page) => {
    await search(page, "gaussian");
    await page.getByRole("textbox", { name: "Sigma", exact: true }).fill("2mm");
    await page.keyboard.press("Tab");
    await page.getByRole("button", { name: "Apply", exact: true }).click();
    await page.getByRole("progressbar").waitFor();
    assert.deepEqual(page.sent.find((m) => m.type === "run").parameters, { sigma: "2mm" });
    await page.getByRole("button", { name: "Cancel gaussian" }).click();
    await page.getByText("gaussian was cancelled.").first().waitFor();
  }));

  test("a step is put between two others after a preview of it, in one commit", () => withPage(["--made"], async (page) => {
    await page.locator(".tree-name", { hasText: "smooth" }).click();
    await page.getByRole("button", { name: "Insert after" }).click();
    await page.getByRole("button", { name: /^Unsharp/ }).click();
    await page.locator("[data-preview] img").waitFor();
    await page.getByRole("button", { name: "Apply", exact: true }).click();
    await page.locator(".step-title", { hasText: "Unsharp" }).waitFor();
    assert.deepEqual(editsOf(page).map((m) => m.edits), [[
      { op: "add", path: "datasets", id: "unsharp", value: { operation: "unsharp", inputs: { volume: "smooth" } } },
      { op: "set", path: "datasets.clean.inputs.volume", value: "unsharp" },
    ]]);
  }));

  test("people stay where they looked at, with the new step open", () => withPage(["--made"], async (page) => {
    await page.locator(".tree-name", { hasText: "ring" }).first().click();
    await page.getByRole("button", { name: /^Gaussian/ }).click();
    await page.getByRole("button", { name: "Insert after" }).click();
    await page.getByRole("button", { name: /^Unsharp/ }).click();
    await page.getByRole("button", { name: "Apply", exact: true }).click();
    await page.locator(".step", { hasText: "Unsharp" }).getByRole("textbox", { name: "Sigma" }).waitFor();
    assert.equal(await page.locator(".inspector-head h2").textContent(), "ring");
  }));

  test("what an operation cannot do without is there at once; what is typed is previewed without a key", () => withPage([], async (page) => {
    await search(page, "threshold");
    await page.getByText("compare before and after").waitFor();
    const range = page.getByRole("textbox", { name: "Range", exact: true });
    await until(async () => /^\d+(\.\d+)?\.\.$/.test(await range.inputValue()), "no range is proposed");
    await range.fill("nonsense");
    await page.locator(".preview-state .row-error", { hasText: "Sigma: expected a length" }).waitFor();
    await range.fill("90..");
    await page.locator(".preview-state .row-error").waitFor({ state: "detached" });
    assert.equal(await page.evaluate("document.activeElement.value"), "90..");
    await page.keyboard.press("Escape");
    await search(page, "merge");
    await page.getByRole("button", { name: "Add input c" }).click();
    await page.getByRole("combobox", { name: "C", exact: true }).selectOption("");
    assert.deepEqual(await page.locator(".filter-panel .row-label").allInnerTexts(), ["A", "B", "Names"]);
  }));

  test("a choice is kept that is made while the data's proposal is on its way", () => withPage([], async (page) => {
    await search(page, "threshold"); // what is known of the data is known from now on
    await until(async () => /^\d/.test(await page.getByRole("textbox", { name: "Range", exact: true }).inputValue()), "no range is proposed");
    await page.keyboard.press("Escape");
    await page.locator(".filter-panel").waitFor({ state: "detached" });
    await page.evaluate(() => {
      const look = () => { // as soon as the panel is there: before effects of what has just been drawn
        const method = document.querySelector("#p-method");
        if (!method) return;
        seen.disconnect();
        method.value = "otsu";
        method.dispatchEvent(new Event("change", { bubbles: true }));
      };
      const seen = new MutationObserver(look);
      seen.observe(document.body, { subtree: true, childList: true });
    });
    await search(page, "threshold");
    await page.getByText("compare before and after").waitFor();
    await until(() => page.sent.findLast((m) => m.type === "preview")?.parameters.method === "otsu", "the choice is lost");
    assert.deepEqual(page.sent.findLast((m) => m.type === "preview").parameters, { method: "otsu" });
    assert.equal(await page.getByRole("combobox", { name: "Method", exact: true }).last().inputValue(), "otsu");
  }));

  test("shadows and ambient occlusion stand beside the lights, and are switched by name", () => withPage([], async (page) => {
    await page.locator(".tree-name", { hasText: "key" }).click();
    const shadows = page.getByRole("switch", { name: "Shadows", exact: true });
    assert.equal(await shadows.getAttribute("aria-checked"), "false");
    await page.getByRole("combobox", { name: "Lighting", exact: true }).selectOption("cinematic");
    await until(async () => (await shadows.getAttribute("aria-checked")) === "true", "cinematic light is not said to have shadows");
    assert.deepEqual(editsOf(page)[0].edits, [{ op: "set", path: "views.main.render.raycast.lighting", value: "cinematic" }]);
    await page.getByRole("switch", { name: "Ambient occlusion", exact: true }).click();
    await until(() => editsOf(page).length === 2, "it is not switched off");
    assert.deepEqual(editsOf(page)[1].edits, [{ op: "set", path: "views.main.render.raycast.ambient_occlusion", value: false }]);
    await search(page, "shadows and ambient occlusion on");
    await until(() => editsOf(page).length === 3, "the command does nothing");
    assert.deepEqual(editsOf(page)[2].edits, [{ op: "unset", path: "views.main.render.raycast.lighting" }]);
    await page.locator(".tree-name", { hasText: "Rendering" }).click();
    await page.getByRole("combobox", { name: "Method" }).selectOption("surface");
    await page.locator(".tree-name", { hasText: "key" }).click();
    await page.getByText("lights every place as if it were alone").waitFor();
  }));

  test("a switch that is automatic says so, and has the words of its table", () => withPage([], async (page) => {
    await page.locator(".tree-name", { hasText: "Rendering" }).click();
    const jitter = page.getByRole("combobox", { name: "Jitter", exact: true });
    assert.equal(await jitter.inputValue(), "");
    await jitter.selectOption("off");
    await until(() => editsOf(page).length === 1, "it is not set");
    await jitter.selectOption("automatic");
    await until(() => editsOf(page).length === 2, "it is not automatic again");
    const path = "views.main.render.raycast.jitter";
    assert.deepEqual(editsOf(page).map((m) => m.edits[0]), [{ op: "set", path, value: false }, { op: "unset", path }]);
    await page.getByRole("switch", { name: "Skip empty ends", exact: true }).waitFor();
    assert.match(await page.locator("label", { hasText: "Skip empty ends" }).getAttribute("title"), /In scenes and lines: parc\.$/);
  }));

  test("a step that cannot be made says so where it is and over the picture, until it can", () => withPage(["--made"], async (page) => {
    await page.locator(".tree-name", { hasText: "body" }).click();
    const range = page.getByRole("textbox", { name: "Range", exact: true });
    const edit = async (text) => { await range.fill(text); await range.press("Enter"); };
    await edit("");
    await page.locator(".overlay-failed", { hasText: "Threshold cannot be made: expected a range" }).waitFor();
    await page.locator(".step-failed", { hasText: "Cannot be made: expected a range" }).waitFor();
    await waitForPicture(page);
    assert.equal(await page.locator(".dot-refining").count(), 0);
    assert.equal(await page.locator(".picture-outdated").count(), 1);
    await edit("80..");
    await page.locator(".dot-final").waitFor();
    assert.equal(await page.locator(".overlay-failed, .step-failed, .picture-outdated").count(), 0);
  }));

  test("a file that is dropped is sent, then opened", () => withPage(["--empty"], async (page) => {
    const data = await page.evaluateHandle(() => {
      const transfer = new DataTransfer();
      transfer.items.add(new File([new Uint8Array(64)], "drop <b>me</b>.nrrd"));
      return transfer;
    });
    await page.locator("body").dispatchEvent("drop", { dataTransfer: data });
    await until(() => page.sent.some((m) => m.type === "open"), "not opened");
    assert.equal(page.sent.find((m) => m.type === "open").path, "uploads/drop <b>me</b>.nrrd");
    assert.equal(await page.locator("b").count(), 0);
    await waitForPicture(page);
  }));

  test("the Rendering viewport is a client that follows the Navigator", () => withPage([], async (page) => {
    await page.locator("[data-viewport]").focus();
    await page.keyboard.press("v");
    await page.locator(".rendering .dot-final").waitFor();
    await until(() => page.sent.filter((m) => m.type === "hello").length === 2, "no second client");
    const before = page.sent.filter((m) => m.type === "camera").length;
    await page.keyboard.press("ArrowLeft");
    await until(() => page.sent.filter((m) => m.type === "camera").length > before, "it does not follow");
    await page.getByRole("button", { name: "Close the Rendering viewport" }).click();
    await page.locator(".rendering").waitFor({ state: "detached" });
  }));

  test("V shows the Rendering viewport, then slices, then the Navigator alone", () => withPage([], async (page) => {
    await showSlices(page);
    assert.deepEqual(page.sent.filter((m) => m.type === "hello" && m.plane).map((m) => m.plane).sort(), ["axial", "coronal", "sagittal"]);
    await page.locator("[data-slice=coronal] .slice-area").focus();
    await page.keyboard.press("v");
    await page.locator("[data-slice]").first().waitFor({ state: "detached" });
    assert.equal(await page.locator(".rendering").count(), 0);
  }));

  test("keys and wheel step through slices by samples; what follows each other is one gesture", () => withPage([], async (page) => {
    await showSlices(page);
    const slider = page.getByRole("slider", { name: "Axial slice" });
    await until(async () => (await slider.getAttribute("aria-valuetext")) === "0 mm, slice 65 of 128", "the slider does not say which slice");
    await page.locator("[data-slice=axial] .slice-area").focus();
    await page.keyboard.press("ArrowUp");
    await until(() => hairs(page).length === 1, "no step");
    assert.deepEqual(hairs(page)[0].edits[0].value, [0, 0, 1.125]); // samples are at 0.375 + 0.75 k
    await page.keyboard.press("PageDown");
    await until(() => hairs(page).length === 2, "no second step");
    assert.equal(hairs(page)[0].gesture, hairs(page)[1].gesture);
    assert.equal(await page.evaluate(() => window.runHeld()), 1); // the hand has rested
    await page.locator("[data-slice=sagittal] .slice-area").hover();
    await page.mouse.wheel(0, -100);
    await until(() => hairs(page).length === 3, "the wheel does nothing");
    assert.notEqual(hairs(page)[2].gesture, hairs(page)[1].gesture);
    assert.deepEqual(hairs(page)[2].edits[0].value.slice(1), hairs(page)[1].edits[0].value.slice(1));
  }, { init: holdTimers(700) }));

  test("a click moves the cross-hair in all slices, a right drag the window", () => withPage([], async (page) => {
    await showSlices(page);
    const box = await page.locator("[data-slice=axial] .slice-area").boundingBox();
    const upright = () => page.locator("[data-slice=coronal] .cross-hair path").first().getAttribute("d");
    const before = await upright();
    await page.mouse.click(box.x + box.width / 2 + box.height / 4, box.y + box.height / 2);
    await until(() => hairs(page).length > 0, "no cross-hair");
    const [x, y] = hairs(page).at(-1).edits[0].value; // a quarter of 80 to the right, which is the patient's left
    assert.ok(Math.abs(x + 20) < 0.5 && Math.abs(y) < 0.5, `${x} ${y}`);
    await until(async () => (await upright()) !== before, "the other slice has not moved");
    await page.mouse.move(box.x + 50, box.y + 50);
    await page.mouse.down({ button: "right" });
    await page.mouse.move(box.x + 50, box.y + 20, { steps: 3 });
    await page.mouse.up({ button: "right" });
    await until(() => editsOf(page).some((m) => m.edits.some((e) => e.path === "volumes.ring.slices.window_hi")), "no window");
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.getByText(/^143/).first().waitFor(); // what is under the pointer
  }));

  test("a slice fills the page and gives it back", () => withPage([], async (page) => {
    await showSlices(page);
    await page.locator("[data-slice=sagittal] .slice-area").dblclick({ position: { x: 20, y: 20 } });
    await page.locator("[data-slice=axial]").waitFor({ state: "hidden" });
    await page.keyboard.press("Enter");
    await page.locator("[data-slice=axial]").waitFor();
  }));

  test("two browsers see one World", () => withPage([], async (page, mock) => {
    const other = await openPage(browser, mock.url);
    await page.locator(".tree-name", { hasText: "key" }).click();
    await page.keyboard.press("Space");
    await other.locator(".tree-off", { hasText: "key" }).waitFor();
    await closePage(other);
  }));

  test("the page comes back when the server does, with its last picture meanwhile", () => withPage([], async (page, mock) => {
    mock.down();
    await page.getByText("Trying again.").waitFor();
    assert.equal(await page.locator(".picture").isVisible(), true);
    mock.up();
    await page.waitForSelector(".connection-open");
    await page.locator("[aria-live]", { hasText: "The connection is back." }).waitFor({ state: "attached" });
  }));

  test("all sessions are ended: this page stays, the other is sent away, and its link is old", () => withPage([], async (page, mock) => {
    const other = await openPage(browser, mock.url);
    await page.getByTitle("Number of viewers of this scene").waitFor();
    await page.getByRole("button", { name: "connected" }).click();
    await page.getByText("1 other page shows this scene.").waitFor();
    await page.keyboard.press("Escape");
    await page.locator("dialog").waitFor({ state: "detached" });
    await other.waitForSelector(".connection-open");
    await search(page, "end all sessions");
    await page.getByRole("button", { name: "End all sessions" }).click();
    await page.getByText("All other sessions are ended").waitFor();
    await page.waitForSelector(".connection-open");
    await other.getByText("This link is no longer valid").waitFor();
    await page.reload();
    await page.waitForSelector(".connection-open");
    await closePage(other);
  }));

  test("a folder that is a volume is chosen like a file", () => withPage([], async (page) => {
    await page.keyboard.press("Control+o");
    await page.getByRole("button", { name: "scans" }).click();
    const zarr = page.getByRole("button", { name: "embryo.ome.zarr" });
    await zarr.click();
    assert.equal(await zarr.getAttribute("aria-pressed"), "true");
    assert.match(await zarr.textContent(), /volume/);
    assert.equal(await page.getByRole("textbox", { name: "Path" }).inputValue(), "embryo.ome.zarr");
    await zarr.dblclick();
    await until(() => page.sent.some((m) => m.type === "open" && m.path === "scans/embryo.ome.zarr"), "it is not opened");
    await page.locator("dialog").waitFor({ state: "detached" });
  }));

  test("nobody can edit what is read only", () => withPage(["--read-only"], async (page) => {
    assert.equal(await page.getByRole("textbox", { name: "Title" }).isDisabled(), true);
    assert.equal(await page.getByRole("button", { name: "Fog" }).isDisabled(), true);
  }));

  test("at 200 % and on narrow pages nothing is cut off sideways", () => withPage([], async (page) => {
    for (const [width, height] of [[640, 360], [320, 640]]) {
      await page.setViewportSize({ width, height });
      await until(() => page.evaluate("document.scrollingElement.scrollWidth <= innerWidth"), `${width} x ${height} scrolls sideways`);
    }
    await page.getByRole("button", { name: "Show or hide the inspector" }).click();
    await page.locator(".inspector").waitFor();
  }));

  test("the theme is kept", () => withPage([], async (page) => {
    await page.getByRole("button", { name: "Light theme" }).click();
    await page.reload();
    await page.waitForSelector(".connection-open");
    assert.equal(await page.evaluate("document.documentElement.dataset.theme"), "light");
  }));

  test("a file that is there is written over only by the button that says so", () => withPage([], async (page) => {
    await page.keyboard.press("Control+s");
    await page.locator("dialog input:focus").waitFor();
    await page.keyboard.type("taken.vv.json"); // the name has the focus
    await page.keyboard.press("Enter");
    await page.getByText("already exists").waitFor();
    await page.keyboard.press("Enter");
    await until(() => page.sent.filter((m) => m.type === "save").length === 2, "Enter did not ask again");
    assert.ok(page.sent.filter((m) => m.type === "save").every((m) => !m.replace));
    await page.getByRole("textbox", { name: "Name" }).fill("another.vv.json");
    assert.equal(await page.getByRole("button", { name: "Replace" }).count(), 0);
    await page.getByRole("textbox", { name: "Name" }).fill("taken.vv.json");
    await page.getByRole("button", { name: "Replace" }).click();
    await page.locator("dialog").waitFor({ state: "detached" });
    assert.equal(page.sent.filter((m) => m.type === "save").at(-1).replace, true);
  }));

  test("what is selected and gone gives way to the first volume", () => withPage([], async (page) => {
    await page.locator("[data-viewport]").focus();
    await page.keyboard.press("c");
    await page.getByRole("heading", { name: "Cut plane" }).waitFor();
    await page.getByText("The normal points towards the side that is kept.").waitFor();
    await page.keyboard.press("Control+z");
    await page.getByRole("heading", { name: "Cut plane" }).waitFor({ state: "detached" });
    await page.locator(".inspector-head", { hasText: "ring" }).waitFor();
    await page.getByText("drag the points of the curve").waitFor();
  }));

  test("a whole number that is none any more is refused at its field", () => withPage([], async (page) => {
    const field = page.getByRole("textbox", { name: "Component", exact: true });
    await field.fill("1e20");
    await field.press("Enter");
    await page.getByText("Whole numbers beyond 9007199254740991 are not accepted.").waitFor();
    assert.equal(editsOf(page).length, 0);
    await field.fill("1");
    await field.press("Enter");
    await until(() => editsOf(page).length === 1, "a smaller one is not sent");
  }));

  test("help says how far each key turns; notices leave the bars of slices free", () => withPage([], async (page) => {
    await page.getByRole("button", { name: "Keys and gestures" }).click();
    const line = (text) => page.locator(".help-line", { hasText: text });
    assert.match(await line("Rotate by 1 degree about the World's up axis").textContent(), /Shift/);
    assert.doesNotMatch(await line("Rotate by 5 degrees about the World's up axis").textContent(), /Shift/);
    await page.keyboard.press("Escape");
    await page.locator("dialog").waitFor({ state: "detached" });
    await page.locator("[data-viewport]").focus();
    await page.keyboard.press("v");
    await page.keyboard.press("v");
    await page.locator(".slice-bar").nth(2).waitFor();
    await page.keyboard.press("Control+s");
    await page.locator("dialog input:focus").waitFor();
    await page.keyboard.press("Enter");
    const notice = await page.locator(".notice").boundingBox();
    for (const bar of await page.locator(".slice-bar").all()) {
      const box = await bar.boundingBox();
      const apart = box.x + box.width <= notice.x || notice.x + notice.width <= box.x || box.y >= notice.y + notice.height || box.y + box.height <= notice.y;
      assert.ok(apart, JSON.stringify([box, notice]));
    }
    if (process.env.VOLVIS_SHOT) await page.screenshot({ path: process.env.VOLVIS_SHOT });
  }));
});
