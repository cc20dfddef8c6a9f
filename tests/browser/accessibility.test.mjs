// Goal: the accessibility checker axe-core finds no serious or critical problem in any view, in both themes,
// and in a narrow window. Method: run axe-core in Chromium on each view. As a control, run it on a page that
// has known problems.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { after, before, test } from "node:test";
import { archives } from "./support/archives.mjs";
import { playerShows } from "./support/browser.mjs";
import { find, namesFound } from "./support/programs.mjs";
import { leave, visit } from "./support/visit.mjs";

let visitor, page;
const { hi, dice } = archives();
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

before(async () => ({ visitor, page } = await visit([hi, dice])));
after(leave);

/** Returns each finding as text: rule, impact and elements. */
async function findings(of = page) {
  await of.evaluate(axe);
  return of.evaluate(async () => {
    const { violations } = await window.axe.run(document, { resultTypes: ["violations"] });
    return violations.filter(({ impact }) => impact === "serious" || impact === "critical")
      .map(({ id, impact, nodes }) => `${id} (${impact}): ${nodes.slice(0, 5).map(({ html, any }) =>
        `${html.slice(0, 160)} ${any[0]?.message ?? ""}`).join(" | ")}`);
  });
}

const names = namesFound(hi);
const views = {
  groups: ["", () => page.waitForFunction(() => document.querySelectorAll("#groups [role=gridcell]").length > 3)],
  "list, with queries, a selection and the player": [
    `#view=list&q=in:rest_s+%3E+1&q=not:rest_s+%3E+9&q=off-in:nonsense&selected=${names[0]}&play=${names[1]}&t=0.3`,
    async () => {
      await playerShows(page, 1);
      await page.locator("#events summary").click();
      await page.locator("#events li").first().waitFor();
    }],
  "nine animations": [`#view=list&play=${names.slice(0, 9).join(",")}&t=0.3`, () => playerShows(page, 9)],
  "an error in a query": ["#view=list", async () => {
    await page.locator("#query").fill("ball 1 in x 0..1 parsec");
    await page.locator("#query-error mark").waitFor();
    await page.locator("#built-kind").selectOption("number");
  }],
  "plots of a chain": [`#run=${find(dice, "-n", "1").archives[0].run_id}&view=plots&plot=trace.log_constraint`,
    () => page.locator("#plot-place .u-over").waitFor()],
  "no matches": ["#view=list&q=in:rest_s+%3E+999", () => page.locator("#empty").waitFor()],
  keys: ["", async () => {
    await page.locator("#show-keys").click();
    await page.locator("dialog#keys").waitFor();
  }],
};

for (const [name, [hash, reach]] of Object.entries(views)) {
  test(name, async () => {
    await page.emulateMedia({ colorScheme: "light", reducedMotion: "reduce" });
    await visitor.open(hash);
    await reach();
    assert.equal(await page.locator("html").getAttribute("data-theme"), "light");
    assert.deepEqual(await findings(), []);
    await page.emulateMedia({ colorScheme: "dark", reducedMotion: "reduce" });
    await page.locator("html[data-theme=dark]").waitFor();
    await page.waitForTimeout(100);
    assert.deepEqual(await findings(), []);
    visitor.assertNoProblems();
  });
}

test("plots with bars and with a table", async () => {
  await visitor.open(`#run=${find(dice, "-n", "1").archives[0].run_id}&view=plots`);
  await page.locator("button[data-plot]").first().waitFor();
  for (const name of await page.locator("button[data-plot]").evaluateAll((all) => all.map(({ dataset }) => dataset.plot))) {
    if (!/^(pair\.log_prior|diagnosis|levels|rounds)$/.test(name)) continue;
    await page.locator(`button[data-plot="${name}"]`).click();
    await page.waitForFunction(() => document.querySelector("#plot-place").childElementCount > 0);
    assert.deepEqual(await findings(), [], name);
  }
  visitor.assertNoProblems();
});

test("a narrow window", async () => {
  await page.emulateMedia({ colorScheme: "light", reducedMotion: "reduce" });
  await page.setViewportSize({ width: 390, height: 800 });
  await visitor.open();
  await page.waitForFunction(() => document.querySelectorAll("#groups [role=gridcell]").length > 0);
  assert.deepEqual(await findings(), []);
  await page.locator("#toggle-filters").click();
  await page.locator("#query").waitFor();
  assert.deepEqual(await findings(), []);
  // Nothing is wider than the window.
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth) <= 390);
  visitor.assertNoProblems();
});

test("axe-core finds the problems of a bad page", async () => {
  const bad = await visitor.context.newPage();
  await bad.setContent("<html lang=en><title>t</title><main><h1>x</h1><img src=a.png><button></button>" +
    "<p style='color:#bbb;background:#fff'>pale</p></main></html>");
  const found = (await findings(bad)).join("\n");
  for (const rule of ["image-alt", "button-name", "color-contrast"]) assert.match(found, new RegExp(rule));
  await bad.close();
});
