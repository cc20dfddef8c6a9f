// Goal: a link opens the same view in another window. The browser's back and forward buttons restore earlier
// views. The keyboard alone is enough to go from the wall to the player and back. Method: copy links, and
// open them in another window of the same browser.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { archives } from "./support/archives.mjs";
import { playerShows, playerState, Visitor } from "./support/browser.mjs";
import { Gallery } from "./support/gallery.mjs";
import { namesFound } from "./support/programs.mjs";

let gallery, visitor, page;
const { hi, dice, ball } = archives();

before(async () => {
  gallery = await Gallery.start([hi, dice, ball]);
  visitor = await Visitor.enter(gallery, { permissions: ["clipboard-read", "clipboard-write"] });
  page = visitor.page;
});
after(async () => {
  await visitor?.close();
  await gallery?.stop();
});

/** The parts of a page's state that a link must contain. */
const view = (of) => of.evaluate(() => {
  const text = (selector) => document.querySelector(selector)?.textContent ?? "";
  const cells = [...document.querySelectorAll("[role=grid]:not([hidden]) [role=gridcell]")]
    .sort((a, b) => Number(a.dataset.index) - Number(b.dataset.index));
  const { player } = window.sleightGallery;
  const corner = player === null ? null : player.screenOfPlace(0, [0, 0, 0], 0.01);
  return {
    counts: text("#counts"),
    archive: text("[aria-current=page]"),
    crumbs: text("nav.crumbs"),
    chips: [...document.querySelectorAll("#chips > li")].map((chip) => [chip.className, chip.querySelector(".chip-text").textContent]),
    sort: document.querySelector("#sort").value,
    view: document.querySelector("[id^=view-][aria-pressed=true]").id,
    keys: cells.slice(0, 8).map(({ dataset }) => dataset.key),
    chosen: cells.filter((cell) => cell.getAttribute("aria-selected") === "true").map(({ dataset }) => dataset.key),
    labels: player?.labels ?? [],
    time: player === null ? 0 : Math.round(1e3 * player.time) / 1e3,
    sync: document.querySelector("#sync").value,
    camera: corner === null ? null : [corner.x, corner.y].map((value) => Math.round(value)),
  };
});

test("a copied link shows the same in another page", async () => {
  const names = namesFound(hi, "--where", "rest_s > 2", "--sort", "rest_s", "--descending");
  await visitor.open("#view=list");
  for (const [text, key] of [["rest_s > 2", "Enter"], ["any touches west wall during ..0.001s", "Alt+Enter"]]) {
    await page.locator("#query").fill(text);
    await page.locator("#query").press(key);
  }
  await page.locator("#chips > li").nth(1).locator("[data-focus^='on-']").click();
  await page.locator("#sort").selectOption("-rest_s");
  await page.locator("#counts", { hasText: `${names.length} of 40 shown` }).waitFor();
  await page.locator("#list [data-index='1']").click();
  await page.locator("#list [data-index='3']").click();
  await page.locator("#compare").click();
  const { labels } = await playerShows(page, 2);
  assert.deepEqual(labels, [names[1], names[3]]);
  await page.locator("#sync").selectOption("contact");
  await page.locator("#timeline").focus();
  await page.keyboard.press("Home");
  for (let i = 0; i < 4; ++i) await page.keyboard.press("PageUp");
  await page.getByRole("button", { name: "Turn left" }).click();
  await page.getByRole("button", { name: "Zoom in" }).click();
  await page.waitForFunction(() => window.sleightGallery.player.isSettled);
  await page.waitForTimeout(400);
  await page.locator("#copy-link").click();
  await page.locator("#status", { hasText: "copied" }).waitFor();
  const link = await page.evaluate(() => navigator.clipboard.readText());
  assert.ok(link.startsWith(`${gallery.origin}/#run=`), link);
  assert.match(link, /camera=/);
  const before = await view(page);

  const other = await visitor.newPage();
  await other.goto(link);
  await other.locator("#counts", { hasText: `${names.length} of 40 shown` }).waitFor();
  await playerShows(other, 2);
  await other.waitForFunction(() => document.querySelectorAll("#list [role=gridcell]").length > 3);
  assert.deepEqual(await view(other), before);
  await other.close();
  visitor.assertNoProblems();
});

test("links contain the archive, open groups, likeness and the plot; back and forward restore them", async () => {
  await visitor.open();
  await page.getByRole("navigation", { name: "Archives" }).getByRole("button", { name: "dice.h5" }).click();
  await page.locator("#counts", { hasText: "of 24 shown" }).or(page.locator("[aria-current=page]", { hasText: "dice.h5" })).first().waitFor();
  await page.locator("#toolbar-words", { hasText: /group/ }).waitFor();
  await page.waitForFunction(() => document.querySelectorAll("#groups [role=gridcell]").length > 1);
  await page.locator("#groups [role=gridcell] canvas").first().click();
  await page.locator("nav.crumbs", { hasText: "like " }).waitFor();
  await page.locator("#view-list").click();
  await page.locator("#list [data-index='0']").waitFor();
  const list = await view(page);
  const link = page.url();
  await page.locator("#view-plots").click();
  await page.locator("button[data-plot]").first().waitFor();
  await page.goBack();
  await page.locator("#list [data-index='0']").waitFor();
  assert.deepEqual(await view(page), list);
  await page.goForward();
  await page.locator("#view-plots[aria-pressed=true]").waitFor();
  const other = await visitor.newPage();
  await other.goto(link);
  await other.locator("#list [data-index='0']").waitFor();
  await other.waitForFunction((counts) => document.querySelector("#counts").textContent === counts, list.counts);
  assert.deepEqual(await view(other), list);
  await other.close();
  // An invalid link still opens the page.
  await visitor.open("#run=zzz&view=wall&q=in:&play=../../etc/passwd,<b>&camera=1,2&t=x&sort=-nothing");
  assert.match(await page.locator("#counts").innerText(), /^40 of 40 shown/);
  visitor.assertNoProblems();
});

test("from the wall to the player and back by keyboard", async () => {
  await visitor.open();
  await page.waitForFunction(() => document.querySelectorAll("#groups [role=gridcell]").length > 3);
  const focused = () => page.evaluate(() => {
    const { id, dataset, tagName } = document.activeElement;
    return dataset.index ?? (id || tagName);
  });
  // Tab alone reaches the wall.
  let steps = 0;
  do {
    await page.keyboard.press("Tab");
  } while (!(await page.evaluate(() => document.activeElement.getAttribute("role") === "gridcell")) && ++steps < 80);
  assert.ok(steps < 80, "the wall is not reachable by Tab");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowRight");
  assert.equal(await focused(), "2");
  await page.keyboard.press("ArrowLeft");
  assert.equal(await focused(), "1");
  await page.keyboard.press("Enter");
  await page.locator("nav.crumbs", { hasText: "like " }).waitFor();
  await page.keyboard.press("Backspace");
  await page.locator("#counts", { hasText: "40 of 40 shown" }).waitFor();
  await page.keyboard.press("2");
  await page.locator("#list [data-index='0']").waitFor();
  await page.keyboard.press("w");
  await page.keyboard.press("End");
  await page.locator("#list [data-index='39']").waitFor();
  assert.equal(await focused(), "39");
  await page.keyboard.press("Home");
  assert.equal(await focused(), "0");
  await page.keyboard.press("s");
  await page.locator("#list [data-index='0'].is-starred").waitFor();
  await page.keyboard.press("Control+z");
  await page.locator("#list [data-index='0']:not(.is-starred)").waitFor();
  assert.equal(await focused(), "0");
  await page.keyboard.press("Space");
  await page.locator("#selection-words", { hasText: "1" }).waitFor();
  await page.keyboard.press("ArrowRight");
  assert.equal(await focused(), "1");
  await page.keyboard.press("Space");
  await page.locator("#selection-words", { hasText: "2" }).waitFor();
  await page.keyboard.press("c");
  await playerShows(page, 2);
  await page.keyboard.press("p");
  await page.keyboard.press("]");
  await page.waitForFunction(() => window.sleightGallery.player.time > 0 && window.sleightGallery.player.isSettled);
  const { time } = await playerState(page);
  await page.keyboard.press(".");
  await page.waitForFunction((t) => Math.abs(window.sleightGallery.player.time - t - 1 / 60) < 1e-6, time);
  await page.keyboard.press("k");
  await page.waitForFunction(() => window.sleightGallery.player.isPlaying);
  await page.keyboard.press("k");
  await page.waitForFunction(() => !window.sleightGallery.player.isPlaying);
  await page.keyboard.press("Escape");
  await page.locator("#player").waitFor({ state: "hidden" });
  assert.equal(await page.evaluate(() => document.activeElement.getAttribute("role")), "gridcell");
  await page.keyboard.press("/");
  assert.equal(await focused(), "query");
  await page.keyboard.type("rest_s > 2");
  await page.locator("#query-count", { hasText: "matches" }).waitFor();
  await page.keyboard.press("Enter");
  await page.locator("#counts", { hasText: `${namesFound(hi, "--where", "rest_s > 2").length} of 40 shown` }).waitFor();
  // Move the focus from the field to a chip's button.
  await page.keyboard.press("Shift+Tab");
  await page.keyboard.press("?");
  await page.locator("dialog#keys").waitFor();
  await page.keyboard.press("Escape");
  await page.locator("dialog#keys").waitFor({ state: "hidden" });
  visitor.assertNoProblems();
});
