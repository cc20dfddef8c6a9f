// Goal: `sleight gallery JOB` shows the animations that a service's job has kept so far, and offers new ones
// while the job runs. The gallery reports an unreachable service, and recovers once the service is back.
// Method: start a daemon in its own folder, and a job that finds animations one by one. Open a gallery of the
// job in Chromium.
import assert from "node:assert/strict";
import { existsSync, mkdirSync, readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { after, before, test } from "node:test";
import { Visitor } from "./support/browser.mjs";
import { Gallery } from "./support/gallery.mjs";
import { besides, ended, find, run, sleight, source, start, temporaryFolder } from "./support/programs.mjs";

const folder = temporaryFolder("service");
const state = join(folder, "state");
const env = { SLEIGHT_STATE: state, XDG_CONFIG_HOME: join(folder, "config") };
const home = join(folder, "home");

let daemon, gallery, visitor, page, job, watch;

/** While the run grows, the server answers requests for an older generation with 409, and the page repeats them. */
const ofGrowing = /status of 409 .*\/api\/(find|groups|alike)\b/;

async function serve() {
  daemon = start(besides("sleightd"), [], { home, env });
  for (let i = 0; i < 100; ++i) {
    try {
      run(sleight, ["server", "status"], { home, env });
      return;
    } catch {
      await new Promise((resolve) => setTimeout(resolve, 100));
    }
  }
  throw new Error("the daemon doesn't answer");
}
const ask = (...args) => JSON.parse(run(sleight, [...args, "--json"], { home, env }));

before(async () => {
  mkdirSync(home, { recursive: true });
  await serve();
  // The job runs longer than the test, which cancels it.
  job = ask("submit", join(source, "requests/die.toml"), "--set", "stop.rounds=9", "--set", "output.min_distance=0.1",
    "--cores", "1").id;
});
after(async () => {
  watch?.kill();
  await visitor?.close();
  await gallery?.stop();
  daemon?.kill("SIGKILL");
  // Processes that run jobs outlive the daemon.
  const jobs = join(state, "jobs");
  for (const id of existsSync(jobs) ? readdirSync(jobs) : []) {
    try {
      process.kill(JSON.parse(readFileSync(join(jobs, id, "attempt.json"), "utf8")).keeper.pid, "SIGKILL");
    } catch { /* it has ended */ }
  }
});

test("a running job: its animations are shown, and new ones are offered", async () => {
  let told = 0;
  watch = start(sleight, ["watch", String(job), "--json"], { home, env });
  createInterface({ input: watch.stdout }).on("line", (line) => {
    if (JSON.parse(line).kind === "solution") ++told;
  });
  while (told < 3) await new Promise((resolve) => setTimeout(resolve, 50));
  watch.kill();
  gallery = await Gallery.start([String(job)], { home, env });
  visitor = await Visitor.enter(gallery);
  page = visitor.page;
  await page.locator("#live", { hasText: /scans/ }).waitFor();
  const counts = await page.locator("#counts").innerText();
  const first = Number(/of ([\d,]+) shown/.exec(counts)[1]);
  assert.ok(first >= 3, counts);
  let offered = 0;
  for (let times = 0; times < 3; ++times) {
    await page.waitForFunction((before) =>
      Number(/(\d+) new/.exec(document.querySelector("#take-new").textContent)?.[1] ?? 0) > before, offered, { polling: 50 });
    offered = Number(/(\d+) new/.exec(await page.locator("#take-new").textContent())[1]);
  }
  // Nothing has moved.
  assert.equal(await page.locator("#counts").innerText(), counts);
  // Give the request for the new groups an older generation, as if the request came too late.
  await page.route("**/api/groups", (route) => {
    const asked = route.request().postDataJSON();
    return route.continue({ postData: JSON.stringify({ ...asked, generation: asked.generation - 1 }) });
  }, { times: 1 });
  const tooLate = page.waitForResponse((response) => /\/api\/groups$/.test(response.url()) && response.status() === 409);
  await page.locator("#take-new").click();
  await tooLate;
  await page.waitForFunction((before) =>
    Number(/of ([\d,]+) shown/.exec(document.querySelector("#counts").textContent)[1]) > before, first);
  // The request was repeated: the groups together contain all animations shown.
  await page.waitForFunction(() => {
    const shown = Number(/of ([\d,]+) shown/.exec(document.querySelector("#counts").textContent)[1].replace(",", ""));
    const kept = [...document.querySelectorAll("#groups [role=gridcell]")]
      .map((card) => Number(/([\d,]+) kept/.exec(card.textContent)?.[1].replace(",", "")));
    return kept.length > 0 && kept.reduce((a, b) => a + b) === shown;
  });
  visitor.assertNoProblems(ofGrowing);
});

test("an unreachable service recovers, and the job's end is shown", async () => {
  daemon.kill("SIGKILL");
  await ended(daemon);
  await page.locator("#live", { hasText: /service|server/i }).waitFor();
  assert.match(await page.locator("#counts").innerText(), /shown/);
  await page.locator("#view-list").click();
  await page.locator("#list [data-index='0']").dblclick();
  await page.waitForFunction(() => window.sleightGallery.player?.isSettled);
  await page.keyboard.press("Escape");
  await serve();
  await page.locator("#live", { hasText: /scans/ }).waitFor({ timeout: 30_000 });
  run(sleight, ["cancel", String(job)], { home, env });
  run(sleight, ["wait", String(job)], { home, env, codes: [11] });
  const archive = join(folder, "fetched.h5");
  run(sleight, ["fetch", String(job), "-o", archive], { home, env });
  const found = find(archive).of;
  await page.waitForFunction((all) => {
    const offered = /(\d+) new/.exec(document.querySelector("#take-new").textContent);
    const shown = Number(/of ([\d,]+) shown/.exec(document.querySelector("#counts").textContent)[1]);
    return document.querySelector("#take-new").hidden ? shown === all : shown + Number(offered?.[1] ?? 0) === all;
  }, found, { timeout: 30_000 });
  if (await page.locator("#take-new").isVisible()) await page.locator("#take-new").click();
  await page.locator("#counts", { hasText: `${found} of ${found} shown` }).waitFor();
  await page.waitForFunction(() => document.querySelector("#live").textContent === "");
  visitor.assertNoProblems(ofGrowing);
});

test("a missing job and a missing service are reported at once", async () => {
  const refused = (args, code) => {
    try {
      run(sleight, ["gallery", ...args, "--no-browser"], { home, env, codes: [] });
    } catch (error) {
      assert.match(error.message, new RegExp(`ended with ${code}: `));
      return error.message;
    }
  };
  assert.match(refused(["999"], 2), /999/);
  daemon.kill("SIGTERM");
  await ended(daemon);
  assert.match(refused([String(job)], 12), /sleight server start/);
});
