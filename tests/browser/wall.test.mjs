// Goal: the wall shows kept animations in groups and as a sorted list, and stores a person's notes. Method:
// use a gallery with an archive of each world in Chromium as a person would. Compare the page's numbers with
// `sleight find`, and its pictures with blank ones.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { archives } from "./support/archives.mjs";
import { cards, inkOf, playerShows, screenshotFor } from "./support/browser.mjs";
import { find, namesFound } from "./support/programs.mjs";
import { leave, visit } from "./support/visit.mjs";

let visitor, page;
const { hi, dice, ball } = archives();

before(async () => ({ visitor, page } = await visit([hi, dice, ball])));
after(leave);

const text = (selector) => page.locator(selector).innerText();
const showArchive = async (name) => {
  await page.getByRole("navigation", { name: "Archives" }).getByRole("button", { name }).click();
  await page.locator(`[aria-current=page]`, { hasText: name }).waitFor();
  await page.waitForFunction(() => !document.querySelector("#toolbar-words").textContent.includes("Grouping"));
};
const listed = () => page.locator("#list [role=gridcell]").evaluateAll((cells) => cells
  .map((cell) => [Number(cell.dataset.index), cell.dataset.key]).sort(([a], [b]) => a - b)
  .map(([, key]) => key));

test("groups contain all kept animations, each with a picture", async () => {
  for (const [name, path, told] of [["hi.h5", hi, "not in proportion"], ["dice.h5", dice, "share"],
    ["ball.h5", ball, "share"]]) {
    await visitor.open();
    await showArchive(name);
    await page.locator("#groups [role=gridcell]").first().waitFor();
    const many = find(path).of;
    assert.match(await text("#counts"), new RegExp(`^${many} of ${many} shown · as of \\S+`));
    await page.locator("#groups-count").fill("5");
    await page.locator("#groups-count").press("Enter");
    await page.waitForFunction(() => /^\d+ groups? of/.test(document.querySelector("#toolbar-words").textContent) &&
      document.querySelectorAll("#groups [role=gridcell]").length <= 5);
    const words = await page.locator("#groups [role=gridcell]").allInnerTexts();
    assert.equal(words.length, 5);
    const kept = words.map((card) => Number(/(\d+) kept/.exec(card)[1]));
    assert.equal(kept.reduce((a, b) => a + b), many, `${name}: ${kept}`);
    for (const card of words) assert.match(card, new RegExp(told));
    await cards(page);
    for (const canvas of await page.locator("canvas[data-thumbnail]").all()) {
      const { colours, other, width, height } = await inkOf(canvas);
      assert.ok(colours > 20 && other > (width * height) / 100, `${name}: a picture has ${colours} colours`);
    }
  }
  // With independent draws, the shares add up to 100%.
  const shares = await page.locator("#groups .card-share").allInnerTexts();
  const total = shares.reduce((sum, words) => sum + Number(/share ([\d.]+)/.exec(words)[1]), 0);
  assert.ok(Math.abs(total - 100) < 3, shares.join("; "));
  visitor.assertNoProblems();
});

test("a group opens into its members, and closes again", async () => {
  await visitor.open();
  const card = page.locator("#groups [role=gridcell]").first();
  const [, kept] = /(\d+) kept/.exec(await card.innerText());
  await card.locator("canvas").click();
  await page.locator("#counts", { hasText: `${kept} of 40 shown` }).waitFor();
  await page.locator("#view-list").click();
  await page.locator("#list [role=gridcell]").first().waitFor();
  assert.equal((await listed()).length, Math.min(Number(kept), (await listed()).length));
  await page.locator("nav.crumbs").getByRole("button", { name: "All" }).click();
  await page.locator("#counts", { hasText: "40 of 40 shown" }).waitFor();
  visitor.assertNoProblems();
});

test("groups open and close by keyboard, and the focus follows", async () => {
  // Goal: keyboard users don't lose their place. Method: use only keys, and check which card has the focus.
  await visitor.open();
  await page.locator("#groups [role=gridcell]").nth(1).waitFor();
  const focused = (grid, index) => page.waitForFunction(([of, at]) =>
    document.activeElement.closest(`#${of}`) && document.activeElement.dataset.index === at, [grid, String(index)]);
  await page.keyboard.press("w");
  await focused("groups", 0);
  await page.keyboard.press("ArrowRight");
  await focused("groups", 1);
  const key = await page.evaluate(() => document.activeElement.dataset.key);
  await page.keyboard.press("Enter");
  await focused("list", 0);
  const name = await page.evaluate(() => document.activeElement.dataset.key);
  await page.keyboard.press("Enter");
  assert.deepEqual((await playerShows(page, 1)).labels, [name]);
  // Leaving the group while an animation plays focuses the card of that group.
  await page.keyboard.press("Backspace");
  await focused("groups", 1);
  assert.equal(await page.evaluate(() => document.activeElement.dataset.key), key);
  await page.keyboard.press("Escape");
  // The page loads subgroups, and the enclosing groups again, without losing the focus.
  await page.keyboard.press("Home");
  await page.keyboard.press("Enter");
  await focused("list", 0);
  await page.keyboard.press("1");
  await page.locator("#toolbar-words", { hasNotText: "Grouping" }).waitFor();
  await focused("groups", 0);
  await page.keyboard.press("Backspace");
  await page.locator("#counts", { hasText: "40 of 40 shown" }).waitFor();
  await focused("groups", 0);
  // A focused field keeps the focus.
  await page.locator("#query").focus();
  await page.goBack();
  await page.locator("#counts", { hasNotText: "40 of 40 shown" }).waitFor();
  assert.equal(await page.evaluate(() => document.activeElement.id), "query");
  visitor.assertNoProblems();
});

test("the list is sorted as `find` sorts", async () => {
  await visitor.open("#view=list");
  await page.locator("#list [role=gridcell]").first().waitFor();
  const seen = (names) => names.slice(0, 6);
  assert.deepEqual(seen(await listed()), seen(namesFound(hi)));
  for (const [number, descending] of [["log_prior", true], ["rest_s", true], ["rest_s", false]]) {
    if (await page.locator("#sort").inputValue() !== `-${number}`) await page.locator("#sort").selectOption(`-${number}`);
    const turned = await text("#sort-turn");
    if (turned.includes("largest") !== descending) await page.locator("#sort-turn").click();
    const expected = namesFound(hi, "--sort", number, ...(descending ? ["--descending"] : []));
    await page.waitForFunction((first) =>
      document.querySelector("#list [data-index='0']")?.dataset.key === first, expected[0]);
    assert.deepEqual(seen(await listed()), seen(expected), number);
  }
  // Sorting by likeness to an animation puts that animation first.
  const first = page.locator("#list [data-index='0']");
  const name = await first.getAttribute("data-key");
  await first.click();
  await page.locator("#more-like").click();
  await page.locator("#toolbar-words", { hasText: `Most similar to ${name} first` }).waitFor();
  // The text changes at the click, but the order changes only when the answer arrives.
  await page.waitForFunction((key) => document.querySelector("#list [data-index='0']")?.dataset.key === key, name);
  assert.equal((await listed())[0], name);
  await page.locator("#unlike").click();
  await page.locator("#toolbar-words", { hasText: `Least similar to ${name} first` }).waitFor();
  assert.notEqual((await listed())[0], name);
  visitor.assertNoProblems();
});

test("stars, tags and hidden animations are stored, and can be undone", async () => {
  await visitor.open("#view=list");
  const cell = (index) => page.locator(`#list [data-index='${index}']`);
  await cell(0).waitFor();
  const [first, second, third] = await listed();
  await cell(0).hover();
  await cell(0).locator("[data-act=star]").click();
  await page.locator(`#list [data-key='${first}'].is-starred`).waitFor();
  await cell(2).click();
  await page.locator("#tag-chosen").fill("good");
  await page.locator("#put-tag").click();
  await page.locator(`#list [data-key='${third}']`, { hasText: "#good" }).waitFor();
  await page.locator("#choose-none").click();
  await cell(1).hover();
  await cell(1).locator("[data-act=hide]").click();
  await page.locator("#counts", { hasText: "39 of 40 shown, 1 hidden by you" }).waitFor();
  assert.ok(!(await listed()).includes(second));
  // The server stores notes soon after the page shows them.
  const isKept = (name, part) => page.waitForFunction(async ([of, what]) => {
    const { notes } = await (await fetch("/api/notes")).json();
    const note = Object.values(notes).map((run) => run[of]).find((found) => found !== undefined);
    return JSON.stringify(note ?? {}).includes(what);
  }, [name, part], { polling: 100 });
  await isKept(first, '"star":true');
  await isKept(second, '"hidden":true');
  await isKept(third, "good");

  await visitor.open("#view=list");
  await page.locator("#counts", { hasText: "39 of 40 shown, 1 hidden by you" }).waitFor();
  await page.locator(`#list [data-key='${first}'].is-starred`).waitFor();
  await page.locator("#filter-tag").selectOption("good");
  await page.locator("#counts", { hasText: "1 of 40 shown" }).waitFor();
  assert.deepEqual(await listed(), [third]);
  await page.locator("#filter-tag").selectOption("");
  await page.locator("#only-starred").check();
  await page.locator("#counts", { hasText: "1 of 40 shown" }).waitFor();
  assert.deepEqual(await listed(), [first]);
  await page.locator("#only-starred").uncheck();
  await page.locator("#filter-hidden").selectOption("only");
  await page.locator("#counts", { hasText: "1 of 40 shown" }).waitFor();
  assert.deepEqual(await listed(), [second]);
  await page.locator("#filter-hidden").selectOption("without");

  // Undo reverses only actions since the page was opened.
  await page.locator(`#list [data-key='${first}']`).hover();
  await page.locator(`#list [data-key='${first}'] [data-act=hide]`).click();
  await page.locator("#counts", { hasText: "38 of 40 shown, 2 hidden by you" }).waitFor();
  await page.keyboard.press("Control+z");
  await page.locator("#counts", { hasText: "39 of 40 shown, 1 hidden by you" }).waitFor();
  await page.keyboard.press("Control+Shift+z");
  await page.locator("#counts", { hasText: "38 of 40 shown, 2 hidden by you" }).waitFor();
  await page.keyboard.press("Control+z");
  await page.locator("#counts", { hasText: "39 of 40" }).waitFor();
  await visitor.open("#view=list");
  await page.locator("#counts", { hasText: "39 of 40 shown, 1 hidden by you" }).waitFor();
  visitor.assertNoProblems();
});

test("a double-click plays any card", async () => {
  // The first click selects the card, which shows the selection bar beneath the wall.
  await visitor.open("#view=list");
  await cards(page);
  const grid = await page.locator("#list").boundingBox();
  const low = await page.locator("#list canvas").evaluateAll((all, bottom) => all.map((canvas) => {
    const { left, top, width } = canvas.getBoundingClientRect();
    return { name: canvas.closest("[role=gridcell]").dataset.key, x: left + width / 2, top };
  }).filter(({ top }) => top < bottom - 15).sort((a, b) => b.top - a.top)[0], grid.y + grid.height);
  const y = Math.max(low.top + 5, grid.y + grid.height - 30);
  await page.mouse.dblclick(low.x, y, { delay: 60 });
  assert.deepEqual((await playerShows(page, 1)).labels, [low.name]);
  visitor.assertNoProblems();
});

test("notes made right before the page closes are stored", async () => {
  const notesOf = () => page.evaluate(async () =>
    Object.assign({}, ...Object.values((await (await fetch("/api/notes")).json()).notes)));
  await visitor.open("#view=list");
  await page.locator("#list [role=gridcell]").first().click();
  await page.keyboard.press("Control+a");
  await page.keyboard.press("s");
  const many = find(hi).of;
  await visitor.open("#view=list");
  const notes = Object.values(await notesOf());
  const hidden = notes.filter(({ hidden: is }) => is).length;
  assert.equal(notes.filter(({ star }) => star).length, many - hidden, "all animations shown");

  const [first] = namesFound(hi);
  await visitor.open(`#play=${first}`);
  await playerShows(page, 1);
  await page.locator("#note-playing").fill("half a sen");
  await page.reload();
  await playerShows(page, 1);
  await page.waitForFunction(() => document.querySelector("#note-playing").value === "half a sen");
  assert.equal((await notesOf())[first].note, "half a sen");
  visitor.assertNoProblems();
});

test("pictures move, or stand still with reduced motion", async () => {
  /** Whether the first picture changes within this time. */
  const changesIn = (ms) => page.locator("canvas[data-thumbnail=drawn]").first().evaluate(async (canvas, most) => {
    const picture = async () => {
      const bitmap = await createImageBitmap(canvas);
      const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
      context.drawImage(bitmap, 0, 0);
      return context.getImageData(0, 0, bitmap.width, bitmap.height).data;
    };
    const before = await picture();
    for (const end = performance.now() + most; performance.now() < end;) {
      await new Promise((resolve) => setTimeout(resolve, 50));
      const now = await picture();
      if (before.length !== now.length || before.some((value, i) => value !== now[i])) return true;
    }
    return false;
  }, ms);
  await visitor.open();
  await cards(page);
  assert.equal(await changesIn(1000), false);
  await page.emulateMedia({ reducedMotion: "no-preference", colorScheme: "light" });
  assert.equal(await changesIn(15_000), true);
  await screenshotFor(page, "gallery_wall");
  await page.emulateMedia({ reducedMotion: "reduce", colorScheme: "light" });
  visitor.assertNoProblems();
});

test("light and dark themes follow the system or the switch", async () => {
  await visitor.open();
  const theme = () => page.locator("html").getAttribute("data-theme");
  const shade = async () => {
    const picture = await page.locator("canvas[data-thumbnail=drawn]").first().evaluate(async (canvas) => {
      const bitmap = await createImageBitmap(canvas, 2, 2, 1, 1);
      const context = new OffscreenCanvas(1, 1).getContext("2d");
      context.drawImage(bitmap, 0, 0);
      return [...context.getImageData(0, 0, 1, 1).data];
    });
    return picture[0] + picture[1] + picture[2];
  };
  await cards(page);
  assert.equal(await theme(), "light");
  assert.ok(await shade() > 450);
  await page.emulateMedia({ colorScheme: "dark", reducedMotion: "reduce" });
  await page.locator("html[data-theme=dark]").waitFor();
  await page.waitForFunction(() => getComputedStyle(document.body).backgroundColor.match(/\d+/g)
    .slice(0, 3).every((value) => Number(value) < 80));
  for (let i = 0; i < 50 && await shade() >= 200; ++i) await page.waitForTimeout(100);
  assert.ok(await shade() < 200);
  await page.locator("#theme").selectOption("light");
  await page.locator("html[data-theme=light]").waitFor();
  await page.locator("#theme").selectOption("system");
  await page.emulateMedia({ colorScheme: "light", reducedMotion: "reduce" });
  await page.locator("html[data-theme=light]").waitFor();
  visitor.assertNoProblems();
});
