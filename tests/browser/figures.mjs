// Goal: measure the gallery's performance with software rendering on this machine, and compare it with the
// limits. Method: serve 5,000 real animations (hi.toml) and a chain of a million draws (million.toml) to
// Debian's Chromium. The script prints a table, and exits with 1 if a limit isn't met. The script needs the
// whole machine, so run it with `deploy/soak gallery`, which runs nothing else at the same time.
//
//   SLEIGHT_BIN=build/release/bin node tests/browser/figures.mjs
//
// SLEIGHT_WANTED and SLEIGHT_MILLION can name existing archives.
import { join } from "node:path";
import { launch } from "./support/browser.mjs";
import { Gallery } from "./support/gallery.mjs";
import { find, run, sleight, source, temporaryFolder } from "./support/programs.mjs";
import { Random } from "./support/random.mjs";
import {
  firstLoadBytes, load, playerRate, postTimes, quantile, randomQuery, scrollFrames, serverMemory, tabMemory,
  wallIsUsable, zoomTimes,
} from "./figures/measures.mjs";

const rows = [];
let isHeld = true;
/** `asked`: a limit {most} or {least}. */
function tell(figure, asked, measured, unit, note = "") {
  const { most, least } = asked;
  const holds = most !== undefined ? measured <= most : measured >= least;
  isHeld &&= holds;
  const bound = most !== undefined ? `<= ${most}` : `>= ${least}`;
  rows.push([figure, `${bound} ${unit}`, `${measured.toFixed(measured < 10 ? 2 : 0)} ${unit}`,
    holds ? "" : "NOT MET", `load ${load()}`, note]);
  console.log(rows.at(-1).join(" | "));
}

function made(given, request) {
  if (given !== undefined) return given;
  const path = join(temporaryFolder("figures"), "a.h5");
  run(sleight, ["direct", join(source, "tests/browser", request), "-o", path, "-q"]);
  return path;
}

const archive = made(process.env.SLEIGHT_WANTED, "hi.toml");
const million = made(process.env.SLEIGHT_MILLION, "million.toml");
const home = temporaryFolder("home");
const browser = await launch();
const pageOf = async (gallery) => {
  const viewport = { width: 1440, height: 900 };
  const context = await browser.newContext({ viewport, colorScheme: "light" });
  const page = await context.newPage();
  page.setDefaultTimeout(120_000);
  await page.goto(gallery.link);
  return page;
};

// Measure the start times, first without stored data about the archive, then with it.
{
  const from = performance.now();
  const gallery = await Gallery.start([archive], { home });
  const page = await pageOf(gallery);
  await page.locator("#counts", { hasText: "shown" }).waitFor();
  const shown = (performance.now() - from) / 1000;
  await wallIsUsable(page);
  tell("wall usable, cold index", { most: 30 }, (performance.now() - from) / 1000, "s",
    `counts shown after ${shown.toFixed(1)} s`);
  await page.context().close();
  await gallery.stop();
}
const from = performance.now();
const gallery = await Gallery.start([archive], { home });
const page = await pageOf(gallery);
await page.locator("#groups [role=gridcell]").first().waitFor();
const carded = (performance.now() - from) / 1000;
await wallIsUsable(page);
tell("wall usable, warm index", { most: 1 }, (performance.now() - from) / 1000, "s",
  `first cards, without pictures, after ${carded.toFixed(1)} s`);

// Measure the times of the server's answers.
const random = new Random();
const { generation } = await page.evaluate(async () => (await (await fetch("/api/gallery")).json()).archives[0]);
const archives = [{ id: 0, generation }];
const queries = Array.from({ length: 300 }, () => ({ query: randomQuery(random), archives }));
// The first request waits for the motions, which are read on demand.
const [first] = await postTimes(page, "/api/find", queries.slice(0, 1));
await page.waitForTimeout(2000);
const finds = await postTimes(page, "/api/find", queries);
const slowest = queries[finds.indexOf(Math.max(...finds))].query;
tell("any query, p99 of 300", { most: 50 }, quantile(finds, 0.99), "ms",
  `median ${quantile(finds, 0.5).toFixed(1)} ms, slowest: ${slowest}; the first after the start ${first.toFixed(0)} ms`);
const asks = [13, 8, 20].flatMap((groups) =>
  ["medoids", "hierarchy"].map((by) => ({ id: 0, generation, entries: null, groups, by })));
const groupings = await postTimes(page, "/api/groups", asks);
const { animations, of } = find(archive, "-n", "9");
const part = Array.from({ length: Math.floor(0.4 * of) }, (_, i) => 2 * i);
const [ofPart] = await postTimes(page, "/api/groups", [{ ...asks[0], entries: part }]);
tell("groups again", { most: 200 }, quantile(groupings, 0.5), "ms",
  `for a new set of ${part.length} ${ofPart.toFixed(0)} ms`);

// Frame rates.
const names = animations.map(({ id }) => id);
const open = async (hash) => {
  await page.goto("about:blank");
  await page.goto(`${gallery.origin}/#${hash}`);
};
const playing = async (some) => {
  await open(`view=list&play=${some.join(",")}`);
  await page.locator("#loop").check();
  const rate = await playerRate(page, 4);
  await page.keyboard.press("Escape");
  return rate;
};
tell("nine animations", { least: 15 }, await playing(names), "frames/s");
tell("one animation", { least: 30 }, await playing(names.slice(0, 1)), "frames/s");
await open("view=list");
await page.locator("#list canvas[data-thumbnail=drawn]").first().waitFor();
const gaps = await scrollFrames(page, 5);
tell("longest frame while scrolling the wall", { most: 100 }, Math.max(...gaps), "ms",
  `median ${quantile(gaps, 0.5).toFixed(0)} ms, p99 ${quantile(gaps, 0.99).toFixed(0)} ms`);
const { tab, gpu } = await tabMemory(browser);
tell("tab's memory", { most: 600 }, tab, "MB", `GPU process ${gpu.toFixed(0)} MB`);
tell("first load, compressed", { most: 250 }, (await firstLoadBytes(page, gallery.origin)) / 1000, "kB");
const memory = serverMemory(gallery.pid);
tell("server's memory", { most: 500 }, memory.now, "MB", `at most ${memory.most.toFixed(0)} MB`);
await page.context().close();
await gallery.stop();

// A plot of a million points.
const long = await Gallery.start([million], { home });
const plots = await pageOf(long);
await plots.keyboard.press("3");
await plots.locator("#plot-place .chart canvas").first().waitFor();
const zooms = await zoomTimes(plots);
tell("zoom in a million points", { most: 50 }, Math.max(...zooms), "ms",
  `median ${quantile(zooms, 0.5).toFixed(1)} ms`);
await browser.close();
await long.stop();

console.log("\nfigure | asked | measured\n---|---|---");
for (const [figure, asked, measured, holds, at, note] of rows)
  console.log(`${figure} | ${asked} | ${measured} ${holds} (${at}${note === "" ? "" : `; ${note}`})`);
process.exit(isHeld ? 0 : 1);
