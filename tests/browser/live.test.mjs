// Goal: an open page stays up to date. The page offers new animations without moving others. The page reports
// damaged, deleted and new archives and a killed server, and recovers. Method: open a gallery in Chromium.
// Replace its archives with longer ones of the same run, and truncate, delete and restore them. Kill the
// server with SIGKILL, and restart it on its port.
import assert from "node:assert/strict";
import { copyFileSync, mkdirSync, readFileSync, renameSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { archives } from "./support/archives.mjs";
import { cards, playerShows, playerState, Visitor } from "./support/browser.mjs";
import { Gallery } from "./support/gallery.mjs";
import { find, namesFound, run, sleight, source, temporaryFolder } from "./support/programs.mjs";

const folder = temporaryFolder("live");
const shown = join(folder, "shown");
const grown = join(shown, "grown.h5");
const other = join(shown, "other.h5");
const { hi } = archives();
/** Archives of the same run, increasingly long. */
const ages = [100, 200, 400].map((scans) => ({ scans, path: join(folder, `${scans}.h5`) }));
for (const { scans, path } of ages) {
  run(sleight, ["direct", join(source, "requests/ball_2d.toml"), "-o", join(folder, "run.h5"), "-q",
    "--set", `stop.scans=${scans}`, "--set", "output.min_distance=0.001", "--set", "output.keep_per_lineage=1000"]);
  copyFileSync(join(folder, "run.h5"), path);
}

let gallery, visitor, page;

before(async () => {
  mkdirSync(shown);
  copyFileSync(ages[0].path, grown);
  gallery = await Gallery.start([shown]);
  visitor = await Visitor.enter(gallery);
  page = visitor.page;
});
after(async () => {
  await visitor?.close();
  await gallery?.kill();
});

/** Writes a temporary file and renames it to the target, as the programs do. */
function put(bytes, path) {
  writeFileSync(`${path}.tmp`, bytes);
  renameSync(`${path}.tmp`, path);
}
const text = (selector) => page.locator(selector).innerText();
const troubleIs = (words) => page.locator("#trouble", { hasText: words }).waitFor({ timeout: 10_000 });
const noTrouble = () => page.locator("#trouble").waitFor({ state: "hidden", timeout: 20_000 });
const place = () => page.evaluate(() => ({
  counts: document.querySelector("#counts").textContent,
  cells: [...document.querySelectorAll("#list [role=gridcell]")].map(({ dataset, offsetTop }) => [dataset.key, dataset.index, offsetTop]),
  scroll: [...document.querySelectorAll("#list, .wall, main")].map(({ scrollTop }) => scrollTop),
  focus: document.activeElement.dataset.key ?? document.activeElement.id,
  chosen: [...document.querySelectorAll("[aria-selected=true]")].map(({ dataset }) => dataset.key),
}));

test("new animations are offered, nothing moves, and a click shows them", async () => {
  let many = find(grown).of;
  await visitor.open("#view=list");
  await page.locator("#list [role=gridcell]").first().waitFor();
  const [name] = namesFound(grown);
  await page.locator("#list [data-index='0']").dblclick();
  await playerShows(page, 1);
  await page.keyboard.press("w");
  await page.keyboard.press("End");
  await page.keyboard.press("Space");
  await page.locator("#selection-words", { hasText: "1" }).waitFor();
  await cards(page);
  for (const { path } of ages.slice(1)) {
    const now = find(path).of;
    assert.ok(now > many, `${now} of ${many}`);
    const before = { ...(await place()), player: await playerState(page) };
    put(readFileSync(path), grown);
    await page.locator("#take-new", { hasText: `${now - many} new` }).waitFor({ timeout: 10_000 });
    await page.waitForTimeout(300);
    const after_ = { ...(await place()), player: await playerState(page) };
    delete before.player.frames;
    delete after_.player.frames;
    assert.deepEqual(after_, before);
    await page.locator("#take-new").click();
    await page.locator("#counts", { hasText: `${now} of ${now} shown` }).waitFor();
    await page.locator("#take-new").waitFor({ state: "hidden" });
    // The player and the selection haven't changed.
    assert.deepEqual((await playerState(page)).labels, [name]);
    assert.equal((await page.locator("#selection-words").innerText()).includes("1"), true);
    many = now;
  }
  visitor.assertNoProblems();
});

test("a link from before the run grew still works", async () => {
  put(readFileSync(ages[0].path), grown);
  await visitor.open("#view=list");
  const before = find(ages[0].path);
  await page.locator("#counts", { hasText: `of ${before.of} shown` }).waitFor({ timeout: 10_000 });
  const names = before.animations.slice(0, 2).map(({ id }) => id);
  await visitor.open(`#run=${before.archives[0].run_id}&view=list&q=in:draw+0..50&play=${names.join(",")}&t=0.25`);
  await playerShows(page, 2);
  const link = page.url();
  put(readFileSync(ages[2].path), grown);
  const found = namesFound(ages[2].path, "--where", "draw 0..50");
  await page.locator("#take-new").waitFor({ timeout: 10_000 });
  await visitor.open(link.slice(link.indexOf("#")));
  const { labels, time } = await playerShows(page, 2);
  assert.deepEqual(labels, names);
  assert.ok(Math.abs(time - 0.25) < 1e-3);
  await page.locator("#counts", { hasText: `${found.length} of ${find(ages[2].path).of} shown` }).waitFor();
  visitor.assertNoProblems();
});

test("a truncated or deleted archive stays visible, and recovers", async () => {
  const whole = readFileSync(ages[2].path);
  await visitor.open("#view=list");
  const counts = await text("#counts");
  put(whole.subarray(0, 40_000), grown);
  await troubleIs(/truncated|damaged|no longer readable/);
  assert.equal(await text("#counts"), counts);
  await page.locator("#query").fill("draw 0..50");
  await page.locator("#query-count", { hasText: "matches" }).waitFor();
  await page.locator("#list [data-index='0']").dblclick();
  await playerShows(page, 1);
  await page.locator("#close-player").click();
  put(whole, grown);
  await noTrouble();
  rmSync(grown);
  await troubleIs(/no longer exists/);
  assert.equal(await text("#counts"), counts);
  put(whole, grown);
  await noTrouble();
  assert.equal(await text("#counts"), counts);
  visitor.assertNoProblems();
});

test("an archive that comes into the folder is there; a link out of it isn't", async () => {
  await visitor.open();
  symlinkSync(hi, join(shown, "outside.h5"));
  copyFileSync(hi, `${other}.tmp`);
  renameSync(`${other}.tmp`, other);
  const button = page.getByRole("navigation", { name: "Archives" }).getByRole("button", { name: "other.h5" });
  await button.waitFor({ timeout: 10_000 });
  await troubleIs(/\(outside\.h5: /);
  assert.equal(await page.getByRole("button", { name: /outside/ }).count(), 0);
  await button.click();
  await page.locator("#counts", { hasText: `of ${find(hi).of} shown` }).waitFor();
  rmSync(join(shown, "outside.h5"));
  await noTrouble();
  visitor.assertNoProblems();
});

/** Messages of a page while its server is dead. */
const ofDeadServer =
  /status of (404|409|503) .*\/api\/find|ERR_CONNECTION_REFUSED|ERR_INCOMPLETE_CHUNKED|ERR_CONNECTION_RESET|ERR_EMPTY_RESPONSE/;

test("a restarted server with a longer run offers the new animations", async () => {
  put(readFileSync(ages[1].path), grown);
  const { archives: [{ run_id: id }], of: many } = find(ages[1].path, "-n", "1");
  await visitor.open(`#run=${id}&view=list`);
  await page.locator("#counts", { hasText: `${many} of ${many} shown` }).waitFor({ timeout: 10_000 });
  await gallery.kill();
  await troubleIs("The server doesn't answer");
  put(readFileSync(ages[2].path), grown);
  await gallery.begin();
  await noTrouble();
  const now = find(ages[2].path, "-n", "1").of;
  await page.locator("#take-new", { hasText: `${now - many} new` }).waitFor({ timeout: 10_000 });
  await page.locator("#view-groups").click();
  await page.locator("#toolbar-words", { hasText: `(${many} in all` }).waitFor();
  const words = await page.locator("#groups [role=gridcell]").allInnerTexts();
  const kept = words.map((card) => Number(/(\d+) kept/.exec(card)[1]));
  assert.equal(kept.reduce((a, b) => a + b), many, kept.join());
  await cards(page);
  visitor.assertNoProblems(ofDeadServer);
});

test("the page waits for a killed server and reconnects", async () => {
  const id = find(grown, "-n", "1").archives[0].run_id;
  await visitor.open(`#run=${id}&view=list`);
  await cards(page);
  const many = find(grown).of;
  const [first, second] = namesFound(grown);
  await gallery.kill();
  await troubleIs("The server doesn't answer");
  // Shown data stays usable, and requests wait.
  await page.locator("#list [data-index='1']").focus();
  await page.locator("#query").fill("draw 0..50");
  await gallery.begin();
  await noTrouble();
  const found = namesFound(grown, "--where", "draw 0..50").length;
  await page.locator("#query-count", { hasText: `matches ${found} of ${many}` }).waitFor();
  assert.equal(await page.locator("#list [data-index='0']").getAttribute("data-key"), first);
  await page.locator("#list [data-index='1']").dblclick();
  assert.deepEqual((await playerShows(page, 1)).labels, [second]);
  // The page is notified of changes again.
  put(readFileSync(ages[1].path), grown);
  put(readFileSync(ages[2].path), grown);
  await page.locator("#close-player").click();
  await page.locator("#list [data-key]").first().hover();
  await page.locator("#list [data-index='0'] [data-act=star]").click();
  await page.locator("#list [data-index='0'].is-starred").waitFor();
  visitor.assertNoProblems(ofDeadServer);
  // Another server at this port doesn't accept the page, and the page reports this.
  await gallery.kill();
  await troubleIs("The server doesn't answer");
  gallery.home = temporaryFolder("other-home");
  await gallery.begin();
  await troubleIs("open the link");
});
