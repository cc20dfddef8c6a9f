// Measures the gallery's performance, with the page or the program itself.
import { readFileSync } from "node:fs";
import { loadavg } from "node:os";
import { gzipSync } from "node:zlib";

/** The machine's load average of the last minute, printed with each result. */
export const load = () => loadavg()[0].toFixed(1);

export function quantile(values, share) {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];
}

/** Resolves when the first card has its picture and the wall was scrolled. */
export async function wallIsUsable(page) {
  await page.locator("#groups canvas[data-thumbnail=drawn]").first().waitFor();
  await page.evaluate(async () => {
    const grid = document.querySelector("#groups");
    grid.scrollTop = 60;
    await new Promise((resolve) => requestAnimationFrame(resolve));
    if (grid.scrollTop === 0 && grid.scrollHeight > grid.clientHeight + 60)
      throw new Error("the wall doesn't scroll");
  });
}

/** A random query of any kind in the language. */
export function randomQuery(random) {
  const ball = () => `ball ${1 + random.below(16)}`;
  const range = (low, high, widest, unit) => {
    const from = random.between(low, high);
    return `${from.toFixed(1)}..${(from + random.between(widest / 10, widest)).toFixed(1)}${unit}`;
  };
  const box = () => `x ${range(-70, 50, 40, "mm")} y ${range(-70, 50, 40, "mm")}`;
  const during = () => (random.uniform() < 0.5 ? ` during ${range(0, 2, 0.6, "s")}` : "");
  const who = () => random.of(["any", "every", ball(), ball(), ball()]);
  const partner = () => random.of(["any", "bins", "ground", ball()]);
  const inside = () => `${who()} in ${box()}${during()}`;
  const touch = () => `${ball()} touches ${partner()}${during()}`;
  const simple = () =>
    random.of([
      inside,
      touch,
      () => `${ball()} ends in ${box()}`,
      () => `${inside()} then ${random.of([inside, touch])()}`,
      () => `log_prior ${range(4400, 4600, 100, "")}`,
      () => `events < ${300 + random.below(300)}`,
    ])();
  return random.of([
    simple,
    simple,
    () => `not (${simple()})`,
    () => `${simple()} and ${simple()}`,
    () => `${simple()} or ${simple()} and ${simple()}`,
  ])();
}

/** Duration of each POST in milliseconds, measured in the page. */
export function postTimes(page, path, bodies) {
  return page.evaluate(
    async ([to, all]) => {
      const times = [];
      for (const body of all) {
        const from = performance.now();
        const answer = await fetch(to, {
          method: "POST",
          headers: { "content-type": "application/json" },
          body: JSON.stringify(body),
        });
        const text = await answer.text();
        if (!answer.ok) throw new Error(`${to}: ${answer.status} ${text}`);
        times.push(performance.now() - from);
      }
      return times;
    },
    [path, bodies],
  );
}

/** Frames per second that the player draws. */
export async function playerRate(page, seconds) {
  await page.waitForFunction(() => {
    const { player } = window.sleightGallery;
    return player?.isPlaying && player.frames > 3;
  });
  return page.evaluate(async (forMs) => {
    const { player } = window.sleightGallery;
    const [frames, from] = [player.frames, performance.now()];
    await new Promise((resolve) => setTimeout(resolve, forMs));
    return (1000 * (window.sleightGallery.player.frames - frames)) / (performance.now() - from);
  }, seconds * 1000);
}

/** Scrolls the list with the wheel; returns the times between the browser's frames, in ms. */
export async function scrollFrames(page, seconds) {
  const box = await page.locator("#list").boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.evaluate(() => {
    const gaps = [];
    let last = performance.now();
    const step = (now) => {
      gaps.push(now - last);
      last = now;
      window.scrollGaps = gaps;
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  });
  const until = performance.now() + seconds * 1000;
  while (performance.now() < until) {
    await page.mouse.wheel(0, 120);
    await page.waitForTimeout(16);
  }
  return page.evaluate(() => window.scrollGaps.slice(2));
}

/** Zooms and moves a plot by keys; returns the milliseconds until each frame is drawn. */
export function zoomTimes(page) {
  return page.evaluate(async () => {
    const chart = document.querySelector("#plot-place .chart");
    chart.focus();
    const frame = () => new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve, 0)));
    const times = [];
    const keys = ["+", "+", "+", "ArrowRight", "ArrowRight", "+", "+", "ArrowLeft", "-", "-", "-", "0"];
    for (const key of [...keys, ...keys]) {
      await frame();
      const from = performance.now();
      chart.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
      // uPlot draws in a microtask, so the measurement ends before the browser paints.
      await new Promise((resolve) => setTimeout(resolve, 0));
      times.push(performance.now() - from);
    }
    return times;
  });
}

/** Compressed bytes of the page's own files at the first load. */
export async function firstLoadBytes(page, origin) {
  const files = [];
  const listen = (response) => {
    const url = new URL(response.url());
    if (!url.pathname.startsWith("/api/")) files.push(response.body());
  };
  page.on("response", listen);
  await page.goto("about:blank");
  await page.goto(origin);
  await page.locator("#groups canvas[data-thumbnail=drawn]").first().waitFor();
  page.off("response", listen);
  const bodies = await Promise.all(files.map((body) => body.catch(() => Buffer.alloc(0))));
  return bodies.reduce((sum, body) => sum + gzipSync(body, { level: 9 }).length, 0);
}

/** Proportional memory of the tab and of the GPU process, in MB. */
export async function tabMemory(browser) {
  const session = await browser.newBrowserCDPSession();
  const { processInfo } = await session.send("SystemInfo.getProcessInfo");
  const most = (type) =>
    Math.max(...processInfo.filter((process) => process.type === type).map(({ id }) => proportional(id)));
  return { tab: most("renderer"), gpu: most("GPU") };
}

function proportional(pid) {
  return kilobytes(`/proc/${pid}/smaps_rollup`, "Pss");
}

/** Resident memory, now and at most, in MB. */
export function serverMemory(pid) {
  const path = `/proc/${pid}/status`;
  return { now: kilobytes(path, "VmRSS"), most: kilobytes(path, "VmHWM") };
}

function kilobytes(path, name) {
  const line = readFileSync(path, "utf8").split("\n").find((text) => text.startsWith(`${name}:`));
  return Number(/(\d+) kB/.exec(line)[1]) / 1000;
}
