// Pictures of every state of the page, to be looked at: node tests/screenshots.mjs FOLDER [STATE...]
import { mkdir } from "node:fs/promises";
import { join } from "node:path";
import { closePage, openPage, startBrowser, startMock, waitForPicture } from "./browser.mjs";
import { states } from "./states.mjs";

const [folder, ...wanted] = process.argv.slice(2);
const sizes = [[1280, 720], [1920, 1080]];
await mkdir(folder, { recursive: true });
const browser = await startBrowser();

async function shoot(name, theme, [width, height], options, go) {
  const mock = await startMock(...options);
  try {
    const page = await openPage(browser, mock.url, { theme, viewport: { width, height } });
    await go(page, mock);
    await page.waitForTimeout(250);
    await page.screenshot({ path: join(folder, `${name}-${theme}-${width}.png`) });
    if (page.problems.length) console.log(name, page.problems);
    await closePage(page);
  } finally {
    mock.stop();
  }
}

const all = [
  { name: "start", options: ["--empty"], go: async () => {} },
  { name: "lost", options: [], go: async (page, mock) => { await waitForPicture(page); mock.stop(); await page.waitForSelector(".banner"); } },
  ...states.map((state) => ({ ...state, options: state.options ?? [], go: async (page) => { await waitForPicture(page); await state.go(page); } })),
].filter((state) => !wanted.length || wanted.includes(state.name));

for (const state of all)
  for (const theme of ["dark", "light"])
    for (const size of theme === "dark" ? sizes : sizes.slice(0, 1))
      await shoot(state.name, theme, size, state.options, state.go).catch((error) => console.log(state.name, theme, error.message.split("\n").slice(0, 4).join(" ")));
await browser.close();
