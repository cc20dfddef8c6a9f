// Debian's Chromium with real but slow WebGL. A page without WebGL hides its blank canvases well, so each
// page opened here is checked for WebGL.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";

const chromiumPath = process.env.SLEIGHT_CHROMIUM ?? "/usr/bin/chromium";

let playwright;
try {
  playwright = await import("playwright-core");
} catch {
  throw new Error("tests/browser/node_modules is missing: run deploy/install-deps");
}
if (!existsSync(chromiumPath)) throw new Error(`${chromiumPath} is missing: run deploy/install-deps`);

// The GL flags enable WebGL; the other flags disable network access.
const flags = [
  "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync",
  "--use-gl=angle", "--use-angle=gl-egl", "--ignore-gpu-blocklist",
];

/** `rules`: for --host-resolver-rules. */
export function launch({ rules } = {}) {
  const args = rules === undefined ? flags : [...flags, `--host-resolver-rules=${rules}`];
  return playwright.chromium.launch({ executablePath: chromiumPath, args });
}

const wide = { width: 1440, height: 900 };

/** A browser that is authorized for a gallery. Pictures stand still, unless a test is about moving ones,
 *  because rendering is in software. */
export class Visitor {
  static async enter(gallery, { rules, ...options } = {}) {
    const visitor = new Visitor();
    visitor.gallery = gallery;
    visitor.browser = await launch({ rules });
    try {
      visitor.context = await visitor.browser.newContext({
        viewport: wide, reducedMotion: "reduce", colorScheme: "light", ...options,
      });
      /** Errors and warnings on any page. */
      visitor.problems = [];
      visitor.page = await visitor.newPage();
      const answer = await visitor.page.goto(gallery.link);
      assert.equal(answer.status(), 200, "the link authorizes the browser");
      await cards(visitor.page);
    } catch (error) {
      // Close the browser, because Node waits for it.
      await visitor.close();
      throw error;
    }
    return visitor;
  }

  /** A page that records its errors and warnings; the gallery isn't opened yet. */
  async newPage(context = this.context) {
    const page = await context.newPage();
    page.setDefaultTimeout(15_000);
    page.on("pageerror", (error) => this.problems.push(`error: ${error.stack ?? error.message}`));
    page.on("console", (message) => {
      if (["error", "warning"].includes(message.type()))
        this.problems.push(`${message.type()}: ${message.text()} (${message.location().url})`);
    });
    return page;
  }

  /** Opens the gallery with `hash` after '#' in the address. */
  async open(hash = "", page = this.page) {
    // Otherwise the browser would only change the address's '#' part.
    await page.goto("about:blank");
    await page.goto(`${this.gallery.origin}/${hash}`);
    await page.locator("#counts", { hasText: "shown" }).waitFor();
    await assertWebGl(page);
    return page;
  }

  /** Fails if there are problems that don't match the pattern. */
  assertNoProblems(but = /^$/) {
    const bad = this.problems.filter((problem) => !but.test(problem));
    this.problems.length = 0;
    assert.deepEqual(bad, []);
  }

  close() { return this.browser.close(); }
}

/** Waits until the pictures of all visible cards are drawn; returns their number. */
export async function cards(page) {
  await assertWebGl(page);
  const drawn = await page.waitForFunction(() => {
    const isInView = (canvas) => {
      const grid = canvas.closest("[role=grid]").getBoundingClientRect();
      const { top, bottom, height } = canvas.getBoundingClientRect();
      return height > 0 && bottom > Math.max(grid.top, 0) && top < Math.min(grid.bottom, innerHeight);
    };
    const all = [...document.querySelectorAll("canvas[data-thumbnail]")].filter(isInView);
    return all.length > 0 && all.every((canvas) => canvas.dataset.thumbnail === "drawn") ? all.length : false;
  });
  return drawn.jsonValue();
}

export async function assertWebGl(page) {
  await page.waitForFunction(() => window.sleightGallery !== undefined);
  assert.ok(await page.evaluate(() => window.sleightGallery.renderer.available),
    "the browser has no WebGL: Chromium's flags for it no longer work here");
}

/** Waits until the player has drawn this many animations; returns its state. */
export async function playerShows(page, count) {
  await page.waitForFunction((wanted) => {
    const player = window.sleightGallery?.player;
    return player && player.labels.length === wanted && player.frames > 0 && player.isSettled;
  }, count);
  return playerState(page);
}
export function playerState(page) {
  return page.evaluate(() => {
    const player = window.sleightGallery.player;
    if (player === null) return null;
    const { labels, time, range, isPlaying, frames } = player;
    return { labels, time, range: { ...range }, isPlaying, frames };
  });
}

/** A canvas's number of colours, and of pixels without the most frequent colour. */
export function inkOf(locator) {
  return locator.evaluate(async (canvas) => {
    const picture = await createImageBitmap(canvas);
    const { width, height } = picture;
    const context = new OffscreenCanvas(width, height).getContext("2d");
    context.drawImage(picture, 0, 0);
    const pixels = new Uint32Array(context.getImageData(0, 0, width, height).data.buffer);
    const counts = new Map();
    for (const pixel of pixels) counts.set(pixel, (counts.get(pixel) ?? 0) + 1);
    return { width, height, colours: counts.size, other: pixels.length - Math.max(...counts.values()) };
  });
}

/** Takes a screenshot for the documents, if SLEIGHT_SCREENSHOTS names a folder. */
export async function screenshotFor(page, name) {
  const folder = process.env.SLEIGHT_SCREENSHOTS;
  if (folder === undefined) return;
  const before = page.viewportSize();
  await page.setViewportSize({ width: 1280, height: 800 });
  await page.waitForTimeout(1500);
  await page.screenshot({ path: `${folder}/${name}.png` });
  if (before !== null) await page.setViewportSize(before);
}
