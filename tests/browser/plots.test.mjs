// Goal: the page draws all plots of an archive. A click on a point opens its animation, and a plot's visible
// range can filter the wall.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { archives } from "./support/archives.mjs";
import { inkOf, playerShows, screenshotFor } from "./support/browser.mjs";
import { find, namesFound, run, sleight } from "./support/programs.mjs";
import { leave, visit } from "./support/visit.mjs";

let visitor, page;
const { hi, dice, ball } = archives();
const runOf = (path) => find(path, "-n", "1").archives[0].run_id;

before(async () => ({ visitor, page } = await visit([hi, dice, ball])));
after(leave);

/** Draws all of an archive's plots; returns their kinds by name. */
async function drawAll(path) {
  await visitor.open(`#run=${runOf(path)}&view=plots`);
  await page.locator("button[data-plot]").first().waitFor();
  const titles = await page.evaluate(async (id) => {
    const { archives: all } = await (await fetch("/api/gallery")).json();
    return (await fetch(`/api/archives/${all.find(({ run: of }) => of === id).id}/series`)).json();
  }, runOf(path));
  const kinds = Object.fromEntries(titles.map(({ name, kind }) => [name, kind]));
  for (const { name, title, kind } of titles) {
    await page.locator(`button[data-plot="${name}"]`).click();
    await page.locator("#plot-title", { hasText: title }).waitFor();
    // The page shows the previous plot until it has read this one.
    await page.waitForFunction(() => document.querySelector("#plot-words").hidden ||
      document.querySelector("#plot-words").textContent !== "Reading …");
    const words = await page.locator("#plot-words").innerText();
    assert.doesNotMatch(words, /cannot|can't|fail|error|invalid/i, `${path}: ${name}`);
    if (kind === "table") {
      assert.ok(await page.locator("#plot-place td").count() > 3, name);
      continue;
    }
    // Lines are drawn one frame later.
    await page.locator("#plot-place :is(.u-wrap, svg)").first().waitFor();
    if (kind !== "trace" && await page.locator("#plot-place .u-wrap").count() === 0) {
      const heights = await page.locator("#plot-place svg :is(rect, path, polyline)").evaluateAll((parts) =>
        parts.map((part) => part.getBBox().height));
      assert.ok(Math.max(...heights) > 20, `${path}: ${name} has no bars: ${heights}`);
      continue;
    }
    // Legends have small canvases too.
    const canvas = page.locator("#plot-place .u-wrap canvas").first();
    await canvas.waitFor();
    await page.waitForTimeout(60);
    const { colours, other, width, height } = await inkOf(canvas);
    assert.ok(colours > 10 && other > (width * height) / 500, `${path}: ${name} has ${colours} colours`);
  }
  visitor.assertNoProblems();
  return kinds;
}

test("all plots of ladders and of plain chains are drawn", async () => {
  const kinds = new Set();
  for (const path of [dice, ball]) for (const kind of Object.values(await drawAll(path))) kinds.add(kind);
  assert.deepEqual([...kinds].sort(), ["index", "levels", "pair", "rounds", "table", "trace"]);
});

test("the index process shows each replica's level over time", async () => {
  await visitor.open(`#run=${runOf(dice)}&view=plots&plot=index`);
  await page.locator("#plot-title", { hasText: "index process" }).waitFor();
  const lines = page.locator("#plot-place .legend li", { hasText: "replica" });
  await lines.first().waitFor();
  const { head, columns } = await page.evaluate(async (id) => {
    const { archives: all } = await (await fetch("/api/gallery")).json();
    const at = all.find(({ run: of }) => of === id).id;
    const bytes = await (await fetch(`/api/archives/${at}/series/index?chain=0`)).arrayBuffer();
    return JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, new DataView(bytes).getUint32(0, true))));
  }, runOf(dice));
  assert.equal(columns.length, 2 + head.replicas);
  assert.equal(await lines.count(), head.replicas);
  assert.ok(head.replicas >= 3);
  visitor.assertNoProblems();
});

test("a search's archive has no chains and reports this", async () => {
  await visitor.open(`#run=${runOf(hi)}&view=plots`);
  await page.locator("#plot-words", { hasText: /no chains/ }).waitFor();
  assert.equal(await page.locator("button[data-plot]").count(), 0);
  visitor.assertNoProblems();
});

test("the table equals the output of `sleight diagnose`", async () => {
  await visitor.open(`#run=${runOf(dice)}&view=plots`);
  await page.locator("button[data-plot]").first().waitFor();
  // Exit code 7 means that chains have not mixed, which is irrelevant here.
  const said = JSON.parse(run(sleight, ["diagnose", dice, "--json"], { codes: [0, 7] }));
  const own = await page.evaluate(async (id) => {
    const { archives: all } = await (await fetch("/api/gallery")).json();
    return (await fetch(`/api/archives/${all.find(({ run: of }) => of === id).id}/diagnosis`)).json();
  }, runOf(dice));
  assert.deepEqual(Object.keys(own).sort(), Object.keys(said).sort());
  const numbers = (value) => JSON.stringify(value).match(/-?\d+(\.\d+)?(e-?\d+)?/g).length;
  assert.equal(numbers(own), numbers(said));
});

test("a point opens its animation, and a range filters the wall", async () => {
  await visitor.open(`#run=${runOf(ball)}&view=plots`);
  await page.locator("button[data-plot]").first().waitFor();
  const trace = await page.evaluate(async (id) => {
    const { archives: all } = await (await fetch("/api/gallery")).json();
    const titles = await (await fetch(`/api/archives/${all.find(({ run: of }) => of === id).id}/series`)).json();
    return titles.find(({ kind }) => kind === "trace").name;
  }, runOf(ball));
  await page.locator(`button[data-plot="${trace}"]`).click();
  const over = page.locator("#plot-place .u-over");
  await over.waitFor();
  await page.waitForTimeout(200);
  await screenshotFor(page, "gallery_plots");
  const box = await over.boundingBox();
  await page.mouse.move(box.x + 0.4 * box.width, box.y + 0.5 * box.height);
  await page.mouse.click(box.x + 0.4 * box.width, box.y + 0.5 * box.height);
  const { labels } = await playerShows(page, 1);
  assert.ok(namesFound(ball).includes(labels[0]), labels[0]);
  const nearest = new RegExp(`${labels[0].replace(".", "\\.")}.* nearest to draw \\d+`);
  await page.locator("#status", { hasText: nearest }).waitFor();
  await page.keyboard.press("Escape");
  await page.locator("#player").waitFor({ state: "hidden" });

  // Zoom with keys, then turn the visible range into a query.
  await page.locator("#plot-place .chart").focus();
  await page.keyboard.press("+");
  await page.locator("#plot-filter-seen").click();
  const chip = page.locator("#chips .chip-text");
  await chip.waitFor();
  const query = await chip.innerText();
  assert.match(query, /^draw \d+\.\.\d+$/);
  const expected = namesFound(ball, "--where", query);
  await page.locator("#counts", { hasText: `${expected.length} of ${find(ball).of} shown` }).waitFor();
  visitor.assertNoProblems();
});
