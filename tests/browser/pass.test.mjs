// Goal: the most important features of the gallery work. The wall shows all kept animations in groups with
// pictures. A query matches the same animations as `sleight find`. The player plays to the end, and bodies
// are drawn where the C++ code computes them. Method: visit a gallery of one archive in Chromium, and check
// the pixels of ten animations. The other files test the rest.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { archives } from "./support/archives.mjs";
import { cards, inkOf, playerShows, playerState, Visitor } from "./support/browser.mjs";
import { Gallery } from "./support/gallery.mjs";
import { judgeBodies } from "./support/pixels.mjs";
import { find, namesFound } from "./support/programs.mjs";
import { Random } from "./support/random.mjs";

const { hi } = archives(["hi"]);
const known = find(hi).animations;

let gallery, visitor, page;
before(async () => {
  gallery = await Gallery.start([hi]);
  // A small window, because software rendering is slow.
  visitor = await Visitor.enter(gallery, { colorScheme: "dark", viewport: { width: 1100, height: 700 } });
  page = visitor.page;
});
after(async () => {
  await visitor?.close();
  await gallery?.stop();
});

test("the wall has all kept animations, in groups with pictures", async () => {
  await page.locator("#groups-count").fill("5");
  await page.locator("#groups-count").press("Enter");
  await page.waitForFunction(() => document.querySelectorAll("#groups [role=gridcell]").length === 5);
  await cards(page);
  const words = await page.locator("#groups [role=gridcell]").allInnerTexts();
  const kept = words.map((card) => Number(/(\d+) kept/.exec(card)[1]));
  assert.equal(kept.reduce((a, b) => a + b), known.length, kept.join());
  const { colours, other, width, height } = await inkOf(page.locator("canvas[data-thumbnail=drawn]").first());
  assert.ok(colours > 20 && other > (width * height) / 100, `a picture has ${colours} colours`);
  visitor.assertNoProblems();
});

test("a query matches as `sleight find` does", async () => {
  const rests = known.map(({ numbers }) => numbers.rest_s).sort((a, b) => a - b);
  const query = `rest_s > ${rests[Math.floor(rests.length / 2)].toFixed(4)}`;
  const found = namesFound(hi, "--where", query);
  assert.ok(found.length > 0 && found.length < known.length, `${found.length} are found`);
  await page.locator("#view-list").click();
  await page.locator("#query").fill(query);
  await page.locator("#query-count", { hasText: `matches ${found.length} of ${known.length}` }).waitFor();
  await page.locator("#query").press("Enter");
  await page.locator("#counts", { hasText: `${found.length} of ${known.length} shown` }).waitFor();
  await page.locator(`#list [data-index='0'][data-key='${found[0]}']`).waitFor();
  await page.locator("#chips").locator("[data-focus^='remove-']").click();
  await page.locator("#counts", { hasText: `${known.length} of ${known.length} shown` }).waitFor();
  visitor.assertNoProblems();
});

test("the player plays to the end", async () => {
  const [{ id, numbers }] = known;
  await page.locator(`#list [data-index='0'][data-key='${id}'] canvas`).dblclick();
  const { labels, range } = await playerShows(page, 1);
  assert.deepEqual([labels, Math.abs(range.to - numbers.rest_s) < 1e-3], [[id], true]);
  await page.locator("#speed").selectOption("4");
  await page.locator("#timeline").focus();
  await page.keyboard.press("Home");
  const { frames } = await playerState(page);
  await page.locator("#play-pause").click();
  await page.waitForFunction(([before, end]) => {
    const { isPlaying, time, frames: drawn } = window.sleightGallery.player;
    return !isPlaying && drawn > before + 1 && Math.abs(time - end) < 1e-3;
  }, [frames, numbers.rest_s]);
  visitor.assertNoProblems();
});

test("bodies are where they should be", () =>
  judgeBodies({ visitor, world: "hi", path: hi, asked: 10, random: new Random(26) }));
