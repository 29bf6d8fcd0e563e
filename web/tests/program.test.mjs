// The page in Chromium and the program behind it, with real data.
import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { copyFileSync, readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:net";
import { join } from "node:path";
import { describe, test } from "node:test";
import { promisify } from "node:util";
import { closePage, OF_COLOURS, openPage, search, TOGETHER, until, violations, waitForPicture } from "./browser.mjs";
import { back, base64Source, browser, changed, drag, file, folder, makePlace, pixels, program, psnr, QUICK, seen, skip, startProgram, withProgram } from "./served.mjs";

/** Of the ball that is measured. */
const valueAt = (p) => Math.max(0, 255 - 10 * Math.hypot(...p.map((v) => v - 23.5)));

/** Nobody is given one of these by the system, so that it is free again when the server is killed. */
async function freePort() {
  for (;;) {
    const port = 10000 + Math.floor(Math.random() * 20000);
    const server = createServer();
    const isFree = await new Promise((resolve) => server.once("error", () => resolve(false)).listen(port, "localhost", () => resolve(true)));
    if (!isFree) continue;
    await new Promise((resolve) => server.close(resolve));
    return port;
  }
}

describe("the program behind the page", TOGETHER, () => {
  test("a head is turned, cut, filtered, taken back, saved, and found again", { skip }, () => withProgram([file], async (page) => {
    const first = await seen(page);
    await drag(page, 160, 20);
    const turned = await changed(page, first, 30, "it did not turn");

    const point = page.getByRole("slider", { name: /^Opacity point 3/ });
    await point.focus();
    for (let i = 0; i < 5; i++) await page.keyboard.press("Shift+ArrowUp");
    const denser = await changed(page, turned, 45, "the transfer function did nothing");

    await page.getByRole("button", { name: "Add a cut plane" }).first().click();
    const cut = await changed(page, denser, 30, "it was not cut");

    await search(page, "gaussian");
    await page.getByRole("textbox", { name: "Sigma", exact: true }).fill("3mm");
    await page.keyboard.press("Tab");
    await page.getByRole("button", { name: "Apply", exact: true }).click();
    await page.locator(".tree-name", { hasText: "gaussian" }).waitFor();
    const smooth = await changed(page, cut, 45, "it was not smoothed");

    await page.keyboard.press("Control+z");
    await page.locator(".tree-name", { hasText: "gaussian" }).waitFor({ state: "detached" });
    await back(page, cut, "undo shows another picture");

    await page.keyboard.press("Control+s");
    await page.getByRole("textbox", { name: "Name" }).fill(join(folder, "kept.vv.json"));
    await page.keyboard.press("Enter");
    await page.locator("dialog").waitFor({ state: "detached" });

    await page.reload();
    await page.waitForSelector(".connection-open");
    await back(page, cut, "after a reload it is another picture");
  }));

  test("a parameter of data that are made is changed where they are shown", { skip }, async () => {
    const scene = join(folder, "made.vv.json");
    await promisify(execFile)(program, ["pipe", file, "gaussian --sigma 1vox", "-o", scene, "--overwrite"], { cwd: folder });
    await withProgram([scene], async (page) => {
      const first = await seen(page);
      await page.locator(".tree-name", { hasText: "gaussian" }).last().click(); // below the volume that shows it
      const sigma = page.getByRole("textbox", { name: "Sigma", exact: true });
      await sigma.fill("9mm");
      await page.keyboard.press("Enter");
      await changed(page, first, 45, "it was not smoothed further");
      await page.getByRole("button", { name: /^Undo/ }).first().click();
      await back(page, first, "undo shows another picture");
      await sigma.fill("9 parsecs");
      await page.keyboard.press("Enter");
      await page.getByText(/datasets\.gaussian\.parameters\.sigma/).first().waitFor();
    });
  });

  test("the saved scene renders to the picture of the page", { skip }, () => withProgram([file], async (page) => {
    const before = await seen(page);
    await drag(page, -80, 40);
    const shown = await changed(page, before, 30, "it did not turn");
    const [width, height] = await page.evaluate(() => { const c = document.querySelector(".picture"); return [c.width, c.height]; });
    await page.keyboard.press("Control+s");
    const scene = join(folder, "same.vv.json");
    await page.getByRole("textbox", { name: "Name" }).fill(scene);
    await page.keyboard.press("Enter");
    await page.locator("dialog").waitFor({ state: "detached" });
    await promisify(execFile)(program, ["render", scene, "-o", join(folder, "same.png"), "--size", `${width}x${height}`]);
    const data = readFileSync(join(folder, "same.png")).toString("base64");
    const rendered = Buffer.from(await page.evaluate(`(async () => {
        ${base64Source}
        const bytes = Uint8Array.from(atob("${data}"), (c) => c.charCodeAt(0));
        const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
        const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
        const context = canvas.getContext("2d");
        context.drawImage(bitmap, 0, 0);
        return base64(context.getImageData(0, 0, bitmap.width, bitmap.height).data);
      })()`), "base64");
    assert.ok(psnr(shown, rendered) >= 40, `PSNR ${psnr(shown, rendered)}`);
  }));

  test("two browsers in one World see each other's edits", { skip }, () => withProgram(QUICK, async (page, served) => {
    await page.locator(".tree-name", { hasText: "key" }).waitFor();
    const other = await openPage(browser, served.url);
    await page.locator(".tree-name", { hasText: "key" }).click();
    await page.keyboard.press("Space");
    await other.locator(".tree-off", { hasText: "key" }).waitFor();
    await closePage(other);
  }));

  test("all sessions are ended: the page that asked stays, also with viewports of its own, others need the new link", { skip }, () => withProgram(QUICK, async (page, served) => {
    const other = await openPage(browser, served.url);
    await page.locator("[data-viewport]").focus();
    await page.keyboard.press("v");
    await page.locator(".rendering .dot-final").waitFor();
    await page.getByRole("button", { name: "connected" }).click();
    await page.getByRole("button", { name: "End all sessions" }).click();
    await page.getByText("All other sessions are ended").waitFor();
    await other.getByText("This link is no longer valid").waitFor();
    await page.waitForSelector(".connection-open");
    await waitForPicture(page);
    await page.locator(".rendering .dot-final").waitFor();
    await page.reload();
    await page.waitForSelector(".connection-open");
    await waitForPicture(page);
    await closePage(other);
  }));

  test("keys and drags do what their bindings say, and each is one step", { skip }, () => withProgram(QUICK, async (page) => {
    const first = await seen(page);
    const box = await page.locator("[data-viewport]").boundingBox();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    const curve = page.getByRole("slider", { name: /^Opacity point 2/ }); // the page knows the window that W moves
    const undone = async (what) => { await page.keyboard.press("Control+z"); await back(page, first, `undo of ${what} shows another picture`); };
    await page.locator("[data-viewport]").focus();

    for (const [key, what] of [["c", "a cut"], ["x", "coordinates"], ["b", "a scale bar"], ["Alt+n", "New"]]) {
      await page.keyboard.press(key);
      if (what === "New") await page.getByRole("heading", { name: "See inside your data" }).waitFor();
      else await changed(page, first, 60, `${what} is not seen`);
      await undone(what);
    }

    await curve.waitFor();
    await page.keyboard.down("w");
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 60, y + 10, { steps: 4 });
    await page.mouse.move(x + 120, y + 20, { steps: 4 });
    await page.mouse.up();
    await page.keyboard.up("w");
    await changed(page, first, 45, "the window did not change");
    await undone("a window");

    await page.mouse.move(x - 60, y - 60);
    await page.mouse.down({ button: "middle" });
    await page.mouse.up({ button: "middle" });
    await changed(page, first, 45, "it was not centred");
  }));

  test("a surface is made of the head, and simplified; what takes a mesh is offered where there is one", { skip }, () => withProgram(QUICK, async (page) => {
    const first = await seen(page);
    await search(page, "simplify", { runs: false });
    await page.getByRole("option", { name: /^Simplify/, disabled: true }).waitFor();
    await page.keyboard.press("Escape");
    await page.locator("dialog").waitFor({ state: "detached" });
    for (const name of ["isosurface", "simplify"]) {
      await search(page, name);
      await page.getByRole("button", { name: "Apply", exact: true }).click();
      await page.locator(".tree-name", { hasText: new RegExp(`${name}$`) }).waitFor();
      await page.locator(".filter-panel").waitFor({ state: "detached" });
    }
    await changed(page, first, 30, "no surface is seen");
    if (process.env.VOLVIS_SHOT) await page.screenshot({ path: process.env.VOLVIS_SHOT });
    await page.locator("dialog").waitFor({ state: "detached" });
    await page.keyboard.press("Control+z");
    await page.keyboard.press("Control+z");
    await back(page, first, "undo shows another picture");
  }));

  test("a filter is previewed, applied, switched off and removed: samples are those that the preview told", { skip }, () => withProgram(QUICK, async (page) => {
    const told = page.locator(".preview-values dd").first();
    /** Values at the cross-hair before and after, once they are others than `not`. */
    const values = async (not = []) => {
      let now;
      await until(async () => {
        now = (await told.textContent({ timeout: 1000 }).catch(() => "")).split("→").map((text) => text.trim());
        return now.length === 2 && String(now) !== String(not);
      }, `the preview stays at ${not}`);
      return now;
    };
    const begin = async (name) => { await search(page, name); await page.locator(".filter-panel h2", { hasText: new RegExp(name, "i") }).waitFor(); };
    const close = () => page.locator(".filter-panel").getByRole("button", { name: "Cancel" }).click();
    await waitForPicture(page);
    await page.locator("[data-viewport]").focus();
    await page.keyboard.press("v");
    await page.keyboard.press("v");
    await page.locator("[data-slice=sagittal][data-final] .cross-hair").waitFor();
    await begin("gaussian");
    for (const plane of ["axial", "coronal", "sagittal"]) await page.locator(`[data-preview=${plane}] img`).waitFor();
    const sigma = page.getByRole("textbox", { name: "Sigma", exact: true });
    const first = await values();
    await sigma.fill("9mm");
    await page.keyboard.press("Enter");
    const second = await values(first);
    assert.equal(second[0], first[0]);
    await sigma.fill("nonsense");
    await page.keyboard.press("Enter");
    await page.getByRole("alert").filter({ hasText: /^Sigma: / }).waitFor();
    await sigma.fill("9mm");
    await page.keyboard.press("Enter");
    await page.locator("[data-preview=axial] img").waitFor();
    assert.deepEqual((await page.locator(".tree-name").allTextContents()).filter((text) => /gaussian/.test(text)), []); // nothing has been run
    await page.getByRole("button", { name: "Apply", exact: true }).click();
    await page.locator(".pipeline .step-title", { hasText: "Gaussian" }).waitFor();

    await begin("median");
    assert.equal((await values())[0], second[1]);
    await close();
    await page.locator(".tree-name", { hasText: "gaussian" }).last().click();
    await page.getByRole("switch", { name: "Gaussian is applied" }).click();
    await page.locator(".step-off").waitFor();
    await begin("median");
    assert.equal((await values())[0], first[0]);
    await close();
    await page.getByRole("button", { name: "Remove Gaussian" }).click();
    await page.locator(".tree-name", { hasText: "gaussian" }).waitFor({ state: "detached" });
    for (const state of ["off", "on"]) {
      await page.keyboard.press("Control+z");
      await page.locator(".tree-name", { hasText: "gaussian" }).last().click();
      await page.locator(state === "off" ? ".step-off" : ".step:not(.step-off):not(.step-source)").waitFor();
    }
    await begin("median");
    assert.equal((await values())[0], second[1]);
  }));
  test("a room measures what is clicked: the program says the same, undo takes it back, and all goes out as CSV", { skip }, () => {
    const place = makePlace();
    const n = 48; // values fall by 10 a step from 255 in the middle of a cube, at (23.5, 23.5, 23.5) mm
    const values = Float32Array.from({ length: n ** 3 }, (_, i) => valueAt([i % n, Math.floor(i / n) % n, Math.floor(i / n / n)]));
    const head = `NRRD0004\ntype: float\ndimension: 3\nsizes: ${n} ${n} ${n}\nencoding: raw\nendian: little\nspacings: 1 1 1\nunits: "mm" "mm" "mm"\n\n`;
    writeFileSync(join(place, "ball.nrrd"), Buffer.concat([Buffer.from(head), Buffer.from(values.buffer)]));
    const labels = Uint8Array.from({ length: n ** 3 }, (_, i) => ([i % n, Math.floor(i / n) % n, Math.floor(i / n / n)].every((v) => v >= 10 && v < 40) ? 7 : 0));
    writeFileSync(join(place, "labels.nrrd"), Buffer.concat([Buffer.from(head.replace("float", "uint8").replace("endian: little\n", "")), Buffer.from(labels.buffer)]));
    const ask = async (words) => JSON.parse((await promisify(execFile)(program, [...words, "--json"], { cwd: place })).stdout);
    const slice = (page) => page.locator("[data-slice=axial] .slice-area");
    const enter = async (page) => {
      await waitForPicture(page);
      await page.locator("[data-viewport]").focus();
      for (const key of ["v", "v", "m"]) await page.keyboard.press(key);
      await page.locator(".measure-tool").first().waitFor();
      await page.locator("[data-slice=axial][data-final]").waitFor();
    };
    const rowsOf = (page) => page.locator(".measure-table tbody tr");
    const measure = async (page, tool, places, where) => {
      const before = await rowsOf(page).count();
      await page.locator(".measure-tool", { hasText: tool }).click();
      const box = where ?? (await slice(page).boundingBox());
      for (const [x, y] of places) await page.mouse.click(box.x + box.width / 2 + x, box.y + box.height / 2 + y);
      await rowsOf(page).nth(before).waitFor();
      await page.keyboard.press("Escape");
      return page.sent.filter((m) => m.type === "edit" && m.edits[0].path === "measurements").at(-1).edits[0].value;
    };
    const withScene = (name, act) => withProgram([name, "--spp", "1"], act, { place });
    const isNear = (a, b, off, what) => assert.ok(Math.abs(a - b) <= off, `${what}: ${a}, expected ${b}`);
    return withScene("ball.nrrd", async (page) => {
      await enter(page);
      const line = await measure(page, /^Distance$/, [[-40, -10], [35, 20]]);
      const [a, b] = line.points;
      assert.equal(line.space, "world");
      isNear(line.figures[0].value, Math.hypot(...a.map((v, i) => v - b[i])), 1e-6, "length");
      assert.equal(a[2], b[2]);
      const words = ["measure", "distance", "ball.nrrd", "--space", "world", ...line.points.flatMap((p) => ["--point", p.join(",")])];
      isNear((await ask(words)).distance, line.figures[0].value, 1e-9, "the program's length");

      const angle = await measure(page, /^Angle$/, [[-40, 0], [0, -30], [40, 0]]);
      // pixels of the picture are square; those of the page are as large as a layout in parts of pixels makes them
      const [across, up] = await slice(page).evaluate((e) => { const r = e.getBoundingClientRect(); return [e.clientWidth / r.width, e.clientHeight / r.height]; });
      isNear(angle.figures[0].value, (2 * Math.atan((40 * across) / (30 * up)) * 180) / Math.PI, 1e-4, "angle");

      const point = await measure(page, /^Point$/, [[30, 25]]);
      isNear(point.figures[0].value, valueAt(point.points[0]), 0.3, "the value at a place"); // between samples of a cone
      const profile = await measure(page, /^Profile$/, [[-50, 0], [50, 0]]);
      const middle = profile.points[0].map((v, i) => (v + profile.points[1][i]) / 2);
      assert.ok(middle.every((v) => Math.abs(v - 23.5) <= 1), `the picture's middle is at ${middle}`);
      await page.locator(".measure-plot").waitFor();

      const lines = async () => {
        const [file] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "Save CSV" }).click()]);
        return readFileSync(await file.path(), "utf8").split("\r\n");
      };
      const csv = await lines();
      assert.equal(csv[0], "name,kind,of,quantity,value,error,unit");
      assert.ok(csv.includes(`distance,distance,ball,distance,${line.figures[0].value},${line.figures[0].error},mm`), csv.join("\n"));
      assert.ok(csv.some((row) => row.startsWith("profile,profile,ball,length,")));

      // a point is dragged: one step, with what comes out of it
      await page.locator(".measure-name", { hasText: /^distance$/ }).click();
      const handle = slice(page).getByRole("button", { name: "Point 2 of 2 of distance" });
      await handle.focus();
      const sent = page.sent.length;
      await page.keyboard.press("Shift+ArrowRight");
      await until(() => page.sent.slice(sent).some((m) => m.edits?.some((e) => e.path === "measurements.distance.figures")), "no new length is kept");
      const kept = page.sent.findLast((m) => m.edits?.some((e) => e.path.endsWith(".figures"))).edits;
      isNear(kept[1].value[0].value, Math.hypot(...kept[0].value[0].map((v, i) => v - kept[0].value[1][i])), 1e-6, "the length after a drag");
      await until(async () => !(await lines()).includes(csv[1]), "the table still has the old length");
      await page.keyboard.press("Control+z");
      await until(async () => (await lines()).includes(csv[1]), "undo does not bring the length back");
      await page.keyboard.press("Control+z");
      await rowsOf(page).nth(3).waitFor({ state: "detached" });

      // by double clicks and Enter lines of any number of points end; Backspace takes one back
      await page.locator(".measure-tool", { hasText: /^Polyline$/ }).click();
      await slice(page).focus();
      const box = await slice(page).boundingBox();
      for (const x of [-40, 0, 20, 40]) await page.mouse.click(box.x + box.width / 2 + x, box.y + box.height / 2 - 40);
      await until(async () => (await slice(page).locator("g[aria-hidden] .measure-dot").count()) === 4, "not all points are drawn");
      await page.keyboard.press("Backspace");
      await page.keyboard.press("Enter");
      await rowsOf(page).nth(3).waitFor();
      assert.equal(page.sent.findLast((m) => m.type === "edit" && m.edits[0].path === "measurements").edits[0].value.points.length, 3);
      assert.deepEqual(await violations(page), []);
    }).then(() => withScene("labels.nrrd", async (page) => {
      await enter(page);
      const label = await measure(page, /^Label$/, [[5, 5]]);
      assert.equal(label.label, 7);
      const figure = (name) => label.figures.find((f) => f.name === name).value;
      assert.equal(figure("volume"), 30 ** 3);
      const region = await measure(page, /^Box$/, [[-100, -60], [90, 50]]);
      assert.match(region.box, /^\d+\.\.\d+,\d+\.\.\d+,(\d+)\.\.\1$/);
      const found = await ask(["measure", "statistics", "labels.nrrd", "--box", region.box]);
      assert.equal(region.figures.find((f) => f.name === "mean").value, found.mean);

      // regions that are drawn: the program says the same of the line that the page gives
      const lineOf = async (name) => {
        await page.evaluate(() => { navigator.clipboard.writeText = async (text) => { window.copied = text; }; });
        await page.getByRole("button", { name: `Copy the command line of ${name}`, exact: true }).click();
        await until(() => page.evaluate(() => window.copied !== undefined), "no line is copied");
        return page.evaluate(() => { const text = window.copied; delete window.copied; return text; });
      };
      const agrees = async (drawn, name) => {
        const words = (await lineOf(name)).match(/(?:[^\s']|'[^']*')+/g).map((word) => word.replaceAll("'", ""));
        const said = await ask(words.slice(1));
        for (const { name: figure, value } of drawn.figures.filter((f) => ["mean", "region_voxels", "region_volume_exact"].includes(f.name))) isNear(said[figure], value, 1e-9 * value, figure);
        return Object.fromEntries(drawn.figures.map((f) => [f.name, f.value]));
      };
      const ellipse = await measure(page, /^Ellipse$/, [[-60, -40], [60, 40]]);
      assert.equal(ellipse.region.kind, "ellipse");
      const of = await agrees(ellipse, "ellipse");
      isNear(of.region_volume_exact, (Math.PI / 4) * ellipse.region.size[0] * ellipse.region.size[1], 1e-6, "the exact volume of one slice");
      isNear(of.region_voxels, of.region_volume_exact, 0.1 * of.region_volume_exact, "counted");
      const sphere = await measure(page, /^Sphere$/, [[0, 0], [40, 0]]);
      await agrees(sphere, "sphere");

      // in the Navigator in the plane that faces the viewer, through what is seen at the first click; also beside the object
      const view = await page.locator("[data-viewport]").boundingBox();
      const facing = await measure(page, /^Ellipse$/, [[0, 0], [view.width / 2 - 4, 30]], view);
      const { right, normal } = facing.region;
      isNear(Math.abs(normal[0]) + Math.abs(normal[1]) > 0.1 && right.reduce((sum, v, i) => sum + v * normal[i], 0), 0, 1e-6, "the plane of the Navigator");
      await agrees(facing, "ellipse2");

      // a polygon ends with Enter, Escape leaves it; in one go it is drawn by a drag
      const corner = (x, y) => [[box.x + box.width / 2 + x, box.y + box.height / 2 + y]][0];
      const box = await slice(page).boundingBox();
      await page.locator(".measure-tool", { hasText: /^Polygon$/ }).click();
      await page.mouse.click(...corner(0, 0));
      await until(async () => (await slice(page).locator("g[aria-hidden] .measure-dot").count()) === 1, "no corner is drawn");
      await page.keyboard.press("Escape");
      for (const [x, y] of [[-50, -40], [50, -40], [0, 50]]) await page.mouse.click(...corner(x, y));
      await until(async () => (await slice(page).locator("g[aria-hidden] .measure-dot").count()) === 3, "not all corners are drawn");
      await page.keyboard.press("Enter");
      await rowsOf(page).nth(5).waitFor();
      const added = () => page.sent.findLast((m) => m.type === "edit" && m.edits[0].path === "measurements").edits[0].value;
      const polygon = added();
      assert.equal(polygon.region.outline.length, 3);
      await agrees(polygon, "polygon");
      await page.mouse.move(...corner(-40, 0));
      await page.mouse.down();
      for (let i = 1; i < 24; i++) await page.mouse.move(...corner(-40 * Math.cos(i / 4), 40 * Math.sin(i / 4)));
      await page.mouse.up();
      await rowsOf(page).nth(6).waitFor();
      assert.ok(added().region.outline.length > 12, "a drag draws an outline");
      await page.keyboard.press("Escape");

      // a corner of the ellipse's rectangle is moved: the one across stays
      await page.locator(".measure-name", { hasText: /^ellipse$/ }).click();
      const handle = slice(page).getByRole("button", { name: "Point 3 of 4 of ellipse" });
      await handle.focus();
      const sent = page.sent.length;
      await page.keyboard.press("Shift+ArrowRight");
      await until(() => page.sent.slice(sent).some((m) => m.edits?.some((e) => e.path === "measurements.ellipse.figures")), "no new figures are kept");
      const kept = page.sent.findLast((m) => m.edits?.some((e) => e.path.endsWith(".figures"))).edits[0].value;
      assert.ok(kept.size[0] !== ellipse.region.size[0] && kept.size[1] === ellipse.region.size[1], JSON.stringify(kept));
      assert.deepEqual(await violations(page), []);
    }));
  });

  test("a room measures what of a mesh is in a region that is drawn on it, as the program does", { skip }, () => {
    const place = makePlace();
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => `v ${(i & 1) * 10} ${((i >> 1) & 1) * 10} ${(i >> 2) * 10}`);
    const faces = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"].map((f) => `f ${f}`);
    writeFileSync(join(place, "block.obj"), `${[...corners, ...faces].join("\n")}\n`);
    // beside a volume, which it hides, what is clicked decides
    const core = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nencoding: raw\nspace dimension: 3\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (3,3,3)\n\n";
    writeFileSync(join(place, "core.nrrd"), Buffer.concat([Buffer.from(core), Buffer.from(Uint8Array.from({ length: 64 }, (_, n) => n))]));
    const both = { schema: 1, datasets: { core: { kind: "regular", path: "core.nrrd" }, block: { kind: "mesh", path: "block.obj" } }, volumes: { core: { data: "core" }, block: { data: "block" } } };
    writeFileSync(join(place, "both.vv.json"), JSON.stringify(both));
    const withRoom = (name, act) => withProgram([name, "--spp", "1"], async (page) => {
      await waitForPicture(page);
      await page.locator("[data-viewport]").focus();
      await page.keyboard.press("m");
      await page.locator(".measure-tool").first().waitFor();
      const view = await page.locator("[data-viewport]").boundingBox();
      const rows = page.locator(".measure-table tbody tr");
      const draw = async (tool, kind, places, end) => {
        const before = await rows.count();
        await page.locator(".measure-tool", { hasText: tool }).click();
        if (kind) await page.locator(".measure-wish select").selectOption(kind);
        for (const [x, y] of places) await page.mouse.click(view.x + view.width / 2 + x, view.y + view.height / 2 + y);
        if (end) await until(async () => (await page.locator(".measure-overlay g[aria-hidden] .measure-dot").count()) === places.length, "not all corners are drawn");
        if (end) await page.keyboard.press(end);
        await rows.nth(before).waitFor();
        await page.keyboard.press("Escape");
        const added = page.sent.filter((m) => m.type === "edit" && m.edits[0].path === "measurements").at(-1).edits[0];
        await page.evaluate(() => { navigator.clipboard.writeText = async (text) => { window.copied = text; }; });
        await page.getByRole("button", { name: `Copy the command line of ${added.id}`, exact: true }).click();
        await until(() => page.evaluate(() => window.copied !== undefined), "no line is copied");
        const line = await page.evaluate(() => { const text = window.copied; delete window.copied; return text; });
        const words = line.match(/(?:[^\s']|'[^']*')+/g).map((word) => word.replaceAll("'", "")).slice(1);
        const said = JSON.parse((await promisify(execFile)(program, [...words, "--json"], { cwd: place })).stdout);
        const figures = Object.fromEntries(added.value.figures.map((f) => [f.name, f.value]));
        for (const name of ["area", "volume"].filter((n) => n in figures)) assert.ok(Math.abs(said[name] - figures[name]) <= 1e-6 * (1 + figures[name]), `${line}: ${said[name]}, in the page ${figures[name]}`);
        return figures;
      };
      await act(draw, page);
    }, { place });
    return withRoom("block.obj", async (draw, page) => {
      const outlined = await draw(/^Polygon$/, "volume", [[0, 0], [50, -50], [60, 40], [-40, 50]], "Enter"); // all the way through
      const ball = await draw(/^Sphere$/, "volume", [[0, 0], [12, 0]]); // around a place on the surface
      const part = await draw(/^Rectangle$/, "area", [[-30, -30], [30, 30]]);
      for (const value of [outlined.volume, ball.volume]) assert.ok(value > 0 && value < 1000, `${value} of 1000`);
      assert.ok(part.area > 0 && part.area < 600, `${part.area} of 600`);
      assert.equal(await page.locator(".measure-tool", { hasText: /^Ellipse$/ }).isDisabled(), true);
    }).then(() => withRoom("both.vv.json", async (draw) => {
      const { area } = await draw(/^Rectangle$/, null, [[-30, -30], [30, 30]]);
      assert.ok(area > 0 && area < 600, `${area} of 600`);
    }));
  });

  test("a colour map is moved by its ends", { skip }, () => withProgram(QUICK, async (page) => {
    const first = await seen(page);
    const ends = page.getByRole("slider", { name: "Where the colour map ends" });
    const before = Number(await ends.getAttribute("aria-valuenow"));
    await ends.focus();
    await page.keyboard.press("Shift+ArrowLeft");
    await changed(page, first, 55, "the colours stay");
    const now = async () => Number(await ends.getAttribute("aria-valuenow"));
    await until(async () => (await now()) < before, `the end of the colour map is not below ${before}`);
    const field = page.getByRole("textbox", { name: "Value where the colour map ends" });
    await until(async () => Number(await field.inputValue()) === (await now()), "the field has another number than the slider");
    await page.keyboard.press("Control+z");
    await back(page, first, "undo shows another picture");
    await until(async () => (await now()) === before, `undo does not bring back ${before}`);
  }));

  test("a light is dragged: what it shines on is brighter; one step takes it back", { skip }, () => withProgram([...QUICK, "--method", "surface"], async (page) => {
    const first = await seen(page);
    await page.locator(".tree-name", { hasText: "fill" }).click();
    await page.keyboard.press("Space"); // alone the key shines
    await page.locator(".tree-name", { hasText: "key" }).click();
    const before = await changed(page, first, 60, "the other light still shines");
    const width = await page.evaluate(() => document.querySelector(".picture").width);
    const sides = (shown) => {
      const sum = [0, 0];
      for (let i = 0; i < shown.length; i += 4) sum[(i / 4) % width < width / 2 ? 0 : 1] += shown[i];
      return sum[0] / sum[1];
    };
    const handle = page.getByRole("button", { name: "Direction of the light key" });
    const drawing = await page.locator(".light-handles").boundingBox();
    const to = async (x) => {
      const at = await handle.locator(".light-dot").boundingBox();
      await page.mouse.move(at.x + at.width / 2, at.y + at.height / 2);
      await page.mouse.down();
      await page.mouse.move(drawing.x + drawing.width / 2 + x, drawing.y + drawing.height / 2, { steps: 5 });
      await page.mouse.up();
    };
    const reach = 0.21 * Math.min(drawing.width, drawing.height); // from the side
    await to(-reach);
    const left = sides(await changed(page, before, 35, "the light did not move"));
    if (process.env.VOLVIS_SHOT) await page.screenshot({ path: process.env.VOLVIS_SHOT });
    await page.keyboard.press("Control+z");
    await back(page, before, "undo shows another picture");
    await to(reach);
    const right = sides(await changed(page, before, 35, "the light did not move"));
    assert.ok(left > 1.5 * right, `the left side to the right one, from the left ${left}, from the right ${right}`);
  }));

  test("the name of a file is a text, whatever it says", { skip }, () => {
    const name = "<img src=x onerror=hacked=1>.nii.gz";
    const place = makePlace();
    copyFileSync(join(folder, file), join(place, name));
    return withProgram([name, "--spp", "1"], async (page) => {
      await seen(page);
      await page.keyboard.press("Control+o");
      await page.locator("dialog").getByText(name).first().waitFor();
      assert.equal(await page.evaluate("document.querySelectorAll('img[src=x]').length"), 0);
      assert.equal(await page.evaluate("typeof hacked"), "undefined");
    }, { place });
  });

  test("a file that is dropped in is opened", { skip }, () => withProgram([], async (page) => {
    await page.getByRole("heading", { name: "See inside your data" }).waitFor();
    const bytes = 32 * 32 * 32;
    const data = await page.evaluateHandle((n) => {
      const transfer = new DataTransfer();
      const values = Uint8Array.from({ length: n }, (_, i) => {
        const [x, y, z] = [i % 32, Math.floor(i / 32) % 32, Math.floor(i / 1024)].map((v) => v - 15.5);
        return Math.max(0, 255 - 16 * Math.hypot(x, y, z));
      });
      const head = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 32 32 32\nencoding: raw\nspacings: 1 1 1\n\n";
      transfer.items.add(new File([head, values], "ball.nrrd"));
      return transfer;
    }, bytes);
    await page.locator("body").dispatchEvent("drop", { dataTransfer: data });
    await page.locator(".tree-name", { hasText: "ball" }).first().waitFor();
    assert.ok((await pixels(page)).some((v, i) => i % 4 < 3 && v > 40));
  }));

  test("the method is changed while the picture is made", { skip }, () => withProgram(QUICK, async (page) => {
    await page.locator(".tree-name", { hasText: "Rendering" }).click();
    const method = page.getByRole("combobox", { name: "Method" });
    const names = await method.locator("option").evaluateAll((all) => all.map((o) => o.value).filter(Boolean));
    for (const frames of [2, 0]) // of the screen, until the next is chosen
      for (const name of names) {
        await method.selectOption(name);
        for (let i = 0; i < frames; i++) await page.evaluate(() => new Promise(requestAnimationFrame));
      }
    await method.selectOption("raycast");
    await seen(page);
  }));

  test("the server is killed and started again: the session is there", { skip }, async () => {
    const place = makePlace();
    const port = String(await freePort());
    let served = await startProgram(["--fresh", "--port", port, ...QUICK], place);
    const page = await openPage(browser, served.url);
    await waitForPicture(page);
    await page.locator(".tree-name", { hasText: "fill" }).click();
    await page.keyboard.press("Delete");
    await page.locator(".tree-name", { hasText: "fill" }).waitFor({ state: "detached" });
    await served.stop("SIGKILL");
    await page.getByText(/Trying again|does not answer/).first().waitFor();
    served = await startProgram(["--port", port, ...QUICK], place);
    const again = await openPage(browser, served.url);
    await waitForPicture(again);
    assert.equal(await again.locator(".tree-name", { hasText: "fill" }).count(), 0);
    await closePage(page);
    await closePage(again);
    await served.stop();
  });

  test("axe finds nothing, in both themes", { skip }, () => withProgram(QUICK, async (page) => {
    await waitForPicture(page);
    assert.deepEqual(await violations(page), []);
    await page.getByRole("button", { name: "Light theme" }).click();
    assert.deepEqual(await violations(page, OF_COLOURS), []);
  }, { reducedMotion: "reduce" }));

  test("a header and its samples that are dropped together open, and a volume beside them", { skip }, () => withProgram([], async (page) => {
    const drop = async (...files) => {
      const data = await page.evaluateHandle((list) => {
        const transfer = new DataTransfer();
        for (const [name, text, zeros] of list) transfer.items.add(new File([text, new Uint8Array(zeros).fill(7)], name));
        return transfer;
      }, files);
      await page.locator("body").dispatchEvent("drop", { dataTransfer: data });
    };
    const head = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 8 8\nencoding: raw\n";
    await drop(["x.raw", "", 512], ["x.nhdr", `${head}data file: x.raw\n`, 0], ["y.nrrd", `${head}\n`, 512]);
    for (const name of ["x", "y"]) await page.locator(".tree-name", { hasText: new RegExp(`^${name}$`) }).first().waitFor();
    assert.equal(await page.locator(".notice-error").count(), 0);
    await drop(["nothing.nrrd", "", 0]);
    await page.getByText("nothing.nrrd is empty").waitFor();
    await drop(["z.nhdr", `${head}data file: z.raw\n`, 0]);
    const said = await page.locator(".notice-error", { hasText: "z.nhdr" }).textContent();
    assert.ok(!said.includes(folder) && !/state/.test(said), said);
  }));
});
