// Goal: a saved gallery shows, finds and plays the same animations as a served gallery. A saved gallery works
// from any web server and as a local file, and loads nothing else. Method: save a gallery with `sleight
// gallery --save`, and open it in Chromium as a file and from a static server. Compare queries with `sleight
// find`, and queries and groups with the served page.
import assert from "node:assert/strict";
import { createReadStream, existsSync, readdirSync, readFileSync } from "node:fs";
import { createServer } from "node:http";
import { extname, join, normalize } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { archives } from "./support/archives.mjs";
import { cards, inkOf, launch, playerShows, Visitor } from "./support/browser.mjs";
import { Gallery } from "./support/gallery.mjs";
import { find, namesFound, run, sleight, temporaryFolder } from "./support/programs.mjs";

const { hi, dice } = archives();
const saved = join(temporaryFolder("saved"), "gallery");
const queries = ["rest_s > 2", "any touches west wall", "not (any touches west wall) and ball 1 ends in x 0.."];

let browser, server, origin, served;
before(async () => {
  const gallery = await Gallery.start([hi, dice]);
  const visitor = await Visitor.enter(gallery);
  served = await said(visitor.page);
  await visitor.close();
  await gallery.stop();
  const { animations } = JSON.parse(run(sleight, ["gallery", hi, dice, "--save", saved, "--json"]));
  assert.equal(animations, find(hi).of + find(dice).of);
  browser = await launch();
  const kinds = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css" };
  server = createServer((request, response) => {
    const path = join(saved, normalize(new URL(request.url, "http://x").pathname).replace(/\/$/, "/index.html"));
    if (!path.startsWith(saved) || !existsSync(path)) {
      response.statusCode = 404;
      response.end();
      return;
    }
    response.setHeader("content-type", kinds[extname(path)] ?? "application/octet-stream");
    createReadStream(path).pipe(response);
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  origin = `http://127.0.0.1:${server.address().port}`;
});
after(async () => {
  await browser?.close();
  server?.close();
});

/** A page's answers to the queries, and its groups. */
async function said(page) {
  const answers = {};
  await page.locator("#groups [role=gridcell]").first().waitFor();
  answers.groups = (await page.locator("#groups [role=gridcell]").evaluateAll((cells) => cells
    .sort((a, b) => a.dataset.index - b.dataset.index).map(({ dataset }) => dataset.key.split(" ").slice(0, 3))));
  await page.locator("#view-list").click();
  for (const query of queries) {
    await page.locator("#query").fill(query);
    await page.locator("#query-count", { hasText: "matches" }).waitFor();
    answers[query] = await page.locator("#query-in").innerText();
    await page.locator("#query").fill("");
    await page.waitForFunction(() => document.querySelector("#query-count").textContent === "");
  }
  await page.locator("#sort").selectOption("-rest_s");
  await page.waitForTimeout(100);
  answers.sorted = await page.locator("#list [role=gridcell]").evaluateAll((cells) => cells
    .map(({ dataset }) => [Number(dataset.index), dataset.key]).sort(([a], [b]) => a - b).slice(0, 4).map(([, key]) => key));
  return answers;
}

for (const way of ["a file", "a static server"]) {
  test(`opened as ${way}`, async () => {
    const address = way === "a file" ? pathToFileURL(join(saved, "index.html")).href : `${origin}/`;
    const context = await browser.newContext({ reducedMotion: "reduce", viewport: { width: 1440, height: 900 } });
    const page = await context.newPage();
    page.setDefaultTimeout(15_000);
    const problems = [];
    const asked = [];
    page.on("pageerror", (error) => problems.push(error.message));
    page.on("console", (message) => { if (["error", "warning"].includes(message.type())) problems.push(message.text()); });
    page.on("request", (request) => asked.push(request.url()));
    await page.goto(address);
    await cards(page);
    assert.ok((await inkOf(page.locator("canvas[data-thumbnail=drawn]").first())).colours > 20);
    await page.locator("#counts", { hasText: `${find(hi).of} of ${find(hi).of} shown` }).waitFor();
    const own = await said(page);
    for (const query of queries)
      assert.match(own[query], new RegExp(`: ${namesFound(hi, "--where", query).length} left$`));
    assert.deepEqual(own.sorted, namesFound(hi, "--sort", "rest_s", "--descending").slice(0, 4));

    assert.deepEqual(own, served);
    // The page plays animations, draws plots and opens links.
    const [first] = own.sorted;
    await page.locator(`#list [data-key='${first}']`).dblclick();
    const { range } = await playerShows(page, 1);
    assert.ok(Math.abs(range.to - find(hi, "--where", `rest_s > ${range.to - 1e-3}`).animations[0].numbers.rest_s) < 1e-3);
    await page.locator("#timeline").focus();
    await page.keyboard.press("PageUp");
    await page.waitForTimeout(400);
    const link = page.url();
    await page.goto("about:blank");
    await page.goto(link);
    assert.deepEqual((await playerShows(page, 1)).labels, [first]);
    await page.locator("#close-player").click();
    await page.getByRole("button", { name: "dice.h5" }).click();
    await page.locator("#counts", { hasText: `of ${find(dice).of} shown` }).waitFor();
    await page.locator("#view-plots").click();
    await page.locator("#plot-place .u-over").waitFor();
    // Stars are stored by the browser.
    await page.locator("#view-list").click();
    await page.locator("#list [data-index='0']").hover();
    await page.locator("#list [data-index='0'] [data-act=star]").click();
    await page.locator("#list [data-index='0'].is-starred").waitFor();
    assert.deepEqual(problems, []);
    const outside = asked.filter((url) => !url.startsWith(address.replace(/index\.html$/, "")) && !/^(blob|data|about):/.test(url));
    assert.deepEqual(outside, []);
    await context.close();
  });
}

test("saved files contain no path of this machine, and saving twice yields the same bytes", () => {
  const again = join(temporaryFolder("saved"), "gallery");
  run(sleight, ["gallery", hi, dice, "--save", again]);
  const files = (folder) => readdirSync(folder, { recursive: true, withFileTypes: true })
    .filter((entry) => entry.isFile()).map((entry) => join(entry.path, entry.name).slice(folder.length)).sort();
  assert.deepEqual(files(again), files(saved));
  for (const file of files(saved)) {
    const bytes = readFileSync(join(saved, file));
    assert.ok(bytes.equals(readFileSync(join(again, file))), file);
    if (bytes.length < 5e6) assert.ok(!bytes.includes(hi), file);
  }
});
