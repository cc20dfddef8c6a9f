// Goal: a query matches the same animations as `sleight find`. The page shows the number of matches before a
// query is applied. People can type queries, or build them from fields, boxes and times. Method: give the
// same queries to a gallery in Chromium and to `sleight find`.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { archives } from "./support/archives.mjs";
import { playerShows } from "./support/browser.mjs";
import { find, namesFound } from "./support/programs.mjs";
import { leave, visit } from "./support/visit.mjs";

let visitor, page;
const { hi, dice } = archives();

before(async () => ({ visitor, page } = await visit([hi, dice])));
after(leave);

const many = find(hi).of;
/** The first names in the list, without scrolling. */
const listed = () => page.locator("#list [role=gridcell]").evaluateAll((cells) => cells
  .map((cell) => [Number(cell.dataset.index), cell.dataset.key]).sort(([a], [b]) => a - b).map(([, key]) => key));
const shows = async (names) => {
  await page.locator("#counts", { hasText: `${names.length} of ${many} shown` }).waitFor();
  if (names.length === 0) return;
  await page.waitForFunction((first) =>
    document.querySelector("#list [data-index='0']")?.dataset.key === first, names[0]);
  const seen = await listed();
  assert.deepEqual(seen, names.slice(0, seen.length));
};
const type = async (text) => {
  await page.locator("#query").fill(text);
};
const countsSay = (alone, inLeft, notLeft) => Promise.all([
  page.locator("#query-count", { hasText: `matches ${alone} of ${many}` }).waitFor(),
  page.locator("#query-in", { hasText: `: ${inLeft} left` }).waitFor(),
  page.locator("#query-not", { hasText: `: ${notLeft} left` }).waitFor(),
]);

// A query that matches some animations, but not all.
const rests = find(hi).animations.map(({ numbers }) => numbers.rest_s).sort((a, b) => a - b);
const middle = ((rests[many / 2 - 1] + rests[many / 2]) / 2).toFixed(4);
const late = `rest_s > ${middle}`;
const touch = "any touches west wall";

test("a typed query is counted, applied, negated, switched off, edited and deleted", async () => {
  await visitor.open("#view=list");
  const lateOnes = namesFound(hi, "--where", late);
  assert.equal(lateOnes.length, many / 2);
  await type(late);
  await countsSay(many / 2, many / 2, many / 2);
  await page.locator("#counts", { hasText: `${many} of ${many} shown` }).waitFor();
  await page.locator("#query").press("Enter");
  await shows(lateOnes);
  const touching = namesFound(hi, "--where", touch);
  const both = namesFound(hi, "--where", late, "--where", touch);
  await type(touch);
  await countsSay(touching.length, both.length, many / 2 - both.length);
  await page.locator("#query").press("Alt+Enter");
  await shows(namesFound(hi, "--where", late, "--not", touch));
  const chip = (index) => page.locator("#chips > li").nth(index);
  await chip(1).locator(".chip-counts", { hasText: `matches ${touching.length}; ${many / 2 - both.length} left` }).waitFor();
  // Remove the negation.
  await chip(1).locator(".chip-sign").click();
  await shows(both);
  await chip(0).locator("[data-focus^='on-']").click();
  await shows(touching);
  await chip(0).locator("[data-focus^='on-']").click();
  await chip(1).locator("[data-focus^='remove-']").click();
  await shows(lateOnes);
  // Edit the query.
  await chip(0).locator("[data-focus^='edit-']").click();
  assert.equal(await page.locator("#query").inputValue(), late);
  await type(`not ${late}`);
  await countsSay(many / 2, many / 2, many / 2);
  await page.locator("#query").press("Enter");
  await shows(namesFound(hi, "--not", late));
  await page.keyboard.press("Escape");
  await page.locator("h1").click();
  await page.keyboard.press("Control+z");
  await shows(lateOnes);
  visitor.assertNoProblems();
});

test("an error is marked at its column", async () => {
  await visitor.open("#view=list");
  await type("ball 1 in x 0..1 parsec");
  const error = page.locator("#query-error");
  await error.filter({ hasText: "Column 18: " }).waitFor();
  assert.equal(await error.locator("mark").innerText(), "p");
  assert.equal(await page.locator("#query").getAttribute("aria-invalid"), "true");
  assert.equal(await page.locator("#query-in").isDisabled(), true);
  await page.locator("#query").press("Enter");
  assert.equal(await page.locator("#chips > li").count(), 0);
  await type("bal 1 in x 0..1");
  await error.filter({ hasText: "did you mean" }).waitFor();
  await type("ball 1 in x 0..1");
  await error.waitFor({ state: "hidden" });
  visitor.assertNoProblems();
});

test("a box in number fields matches as its text does", async () => {
  await visitor.open("#view=list");
  const fields = { "x from in mm": "-12", "x to in mm": "15", "z from in mm": "0", "z to in mm": "20" };
  await page.locator("#built-kind").selectOption("in");
  await page.locator("fieldset.step").locator("select").first().selectOption("body:ball 3");
  for (const [label, value] of Object.entries(fields)) await page.getByLabel(label, { exact: true }).fill(value);
  await page.locator("fieldset.step summary").click();
  await page.getByLabel("time from in s", { exact: true }).fill("0.5");
  await page.getByLabel("time to in s", { exact: true }).fill("0.9");
  const query = await page.locator("#built-query").innerText();
  const expected = namesFound(hi, "--where", "ball 3 in x -12..15mm z 0..20mm during 0.5..0.9s");
  assert.deepEqual(namesFound(hi, "--where", query), expected, query);
  assert.ok(expected.length > 0 && expected.length < many, `${expected.length} are in the box`);
  await page.locator("#built-in", { hasText: `${expected.length} left` }).waitFor();
  await page.locator("#built-not", { hasText: `${many - expected.length} left` }).waitFor();
  await page.locator("#built-in").click();
  await shows(expected);
  await page.locator("#chips > li").locator(".chip-sign").click();
  await shows(namesFound(hi, "--not", query));
  visitor.assertNoProblems();
});

test("conditions on hits, places of rest and numbers can be built", async () => {
  await visitor.open("#view=list");
  await page.locator("#built-kind").selectOption("touches");
  await page.locator("fieldset.step").locator("select").first().selectOption("any:");
  await page.locator("fieldset.step").locator("select").nth(1).selectOption("west wall");
  await page.locator("#built-in", { hasText: `${namesFound(hi, "--where", touch).length} left` }).waitFor();
  await page.locator("#built-in").click();
  await shows(namesFound(hi, "--where", touch));
  await page.locator("#chips [data-focus^='remove-']").click();
  await page.locator("#built-kind").selectOption("ends");
  await page.locator("fieldset.step").locator("select").first().selectOption("body:ball 1");
  await page.getByLabel("x from in mm", { exact: true }).fill("0");
  const right = namesFound(hi, "--where", "ball 1 ends in x 0..");
  await page.locator("#built-in", { hasText: `${right.length} left` }).waitFor();
  await page.locator("#built-not").click();
  await shows(namesFound(hi, "--not", "ball 1 ends in x 0.."));
  visitor.assertNoProblems();
});

test("a box drawn in the player is a query", async () => {
  const [one] = namesFound(hi);
  await visitor.open(`#view=list&play=${one}&t=0.5`);
  await playerShows(page, 1);
  await page.locator("#built-kind").selectOption("in");
  await page.locator(".draw-box").click();
  const canvas = await page.locator("#player-canvas").boundingBox();
  const at = (x, y) => [canvas.x + x * canvas.width, canvas.y + y * canvas.height];
  const before = await page.locator("#built-query").innerText();
  await page.mouse.move(...at(0.4, 0.4));
  await page.mouse.down();
  await page.mouse.move(...at(0.6, 0.6), { steps: 4 });
  await page.mouse.up();
  await page.waitForFunction((text) => {
    const now = document.querySelector("#built-query").textContent;
    return now !== text && / x .*\.\./.test(now);
  }, before);
  const query = await page.locator("#built-query").innerText();
  const expected = namesFound(hi, "--where", query);
  await page.locator("#built-in", { hasText: `${expected.length} left` }).waitFor();
  // A time range is marked on the timeline.
  await page.locator("fieldset.step summary").click();
  await page.locator(".mark-time").click();
  const line = await page.locator("#timeline").boundingBox();
  await page.mouse.move(line.x + 0.2 * line.width, line.y + line.height / 2);
  await page.mouse.down();
  await page.mouse.move(line.x + 0.5 * line.width, line.y + line.height / 2, { steps: 4 });
  await page.mouse.up();
  await page.waitForFunction(() => / during /.test(document.querySelector("#built-query").textContent));
  const timed = await page.locator("#built-query").innerText();
  const during = namesFound(hi, "--where", timed);
  await page.locator("#built-in", { hasText: `${during.length} left` }).waitFor();
  await page.locator("#built-in").click();
  await shows(during);
  visitor.assertNoProblems();
});
