// Goal: the page shows every text of an archive as text, never as markup, and reports archives that the
// reader refuses. Method: copy an archive of dice once for each kind of text: names of features, numbers,
// units, world, run and proposals, and the request. Put markup into that text (support/hostile_archives.py),
// and open the copies in all views. Detect scripts and event attributes that ran, and elements that were
// created from the markup.
import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { archives } from "./support/archives.mjs";
import { playerShows, Visitor } from "./support/browser.mjs";
import { Gallery } from "./support/gallery.mjs";
import { namesFound, run, source, temporaryFolder } from "./support/programs.mjs";

const folder = join(temporaryFolder("hostile-archives"), "shown");
const { dice } = archives();
const [one, two] = namesFound(dice);

let gallery, visitor, page, state;
before(async () => {
  mkdirSync(folder);
  run("/usr/bin/python3", [join(source, "tests/browser/support/hostile_archives.py"), dice, folder]);
  gallery = await Gallery.start([folder]);
  visitor = await Visitor.enter(gallery);
  page = visitor.page;
  await page.waitForFunction(async () =>
    (await (await fetch("/api/gallery")).json()).archives.every((archive) => archive.state !== "reading"));
  state = await page.evaluate(async () => (await fetch("/api/gallery")).json());
});
after(async () => {
  await visitor?.close();
  await gallery?.stop();
});

const idOf = (name) => state.archives.find((archive) => archive.name === `${name}.h5`);
/** Fails if an element of the page was created from an archive's text. */
const assertTextAlone = async (where) => {
  const bad = await page.evaluate(() => [...document.querySelectorAll("*")].filter((element) =>
    (element.tagName === "SCRIPT" && !element.src) || ["IMG", "B", "I", "IFRAME", "OBJECT"].includes(element.tagName) ||
    [...element.attributes].some(({ name, value }) => name.startsWith("on") || (name !== "title" && name !== "aria-label" &&
      name !== "value" && !name.startsWith("data-") && /^\s*javascript:/i.test(value)))).map(({ outerHTML }) => outerHTML.slice(0, 200)));
  assert.deepEqual(bad, [], where);
  visitor.assertNoProblems();
};

test("readable and refused archives are distinguished", () => {
  const states = Object.fromEntries(state.archives.map(({ name, state: of }) => [name.replace(".h5", ""), of]));
  assert.equal(states.number, "damaged");
  assert.match(idOf("number").words, /^\/animations: .*\bname\b/);
  for (const name of ["feature_names", "world", "unit", "run", "kind_of_proposal", "request"])
    assert.equal(states[name], "ready", `${name}: ${idOf(name).words}`);
});

test("archives' texts stay text in all views", async () => {
  for (const name of ["feature_names", "world", "unit", "run", "kind_of_proposal", "request"]) {
    const chosen = new URLSearchParams({ run: idOf(name).run, archive: `${name}.h5`, play: `${one},${two}`, view: "list", t: "0.1" });
    await visitor.open(`#${chosen}`);
    assert.equal(await page.locator("#archive option:checked, [aria-current=page]").first().innerText(), `${name}.h5`);
    await playerShows(page, 2);
    await page.locator("#events summary").click();
    await page.locator("#events li").first().waitFor();
    await page.locator("#show-keys").click();
    await page.keyboard.press("Escape");
    await assertTextAlone(name);
    if (name === "feature_names") {
      assert.ok((await page.locator("#filters").innerHTML()).includes("&lt;i onclick=a()&gt;\"'&amp;"));
      assert.match(await page.locator("#events").innerText(), /javascript:a\(\)\/\/<b>/);
      await page.locator("#built-kind").selectOption("touches");
      await page.locator("fieldset.step").first().locator("select").nth(1).selectOption("javascript:a()//<b>");
      await page.locator("#built-in:not([disabled])").click();
      await page.locator("#chips .chip-counts", { hasText: "matches" }).waitFor();
      await assertTextAlone("a query of such names");
    }
  }
  for (const name of ["unit", "kind_of_proposal"]) {
    await visitor.open(`#${new URLSearchParams({ run: idOf(name).run, archive: `${name}.h5`, view: "plots" })}`);
    await page.locator("button[data-plot]").first().waitFor();
    const plots = await page.locator("button[data-plot]").evaluateAll((all) => all.map(({ dataset }) => dataset.plot));
    for (const plot of plots.filter((of) => /ladder|end_s|diagnosis/.test(of))) {
      await page.locator(`button[data-plot="${plot}"]`).click();
      await page.waitForFunction(() => document.querySelector("#plot-words").hidden);
      await assertTextAlone(`${name}: ${plot}`);
    }
  }
});
