// Debian's Chromium with a real, if slow, WebGL. A page that has none shows blank canvases and hides
// it well, so each page that is opened here is asked for it.
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

// Without the GL flags there is no WebGL; the others keep it from the network.
const flags = [
  "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync",
  "--use-gl=angle", "--use-angle=gl-egl", "--ignore-gpu-blocklist",
];

/** `rules`: of --host-resolver-rules. */
export function launch({ rules } = {}) {
  const args = rules === undefined ? flags : [...flags, `--host-resolver-rules=${rules}`];
  return playwright.chromium.launch({ executablePath: chromiumPath, args });
}

const wide = { width: 1440, height: 900 };

/**
 * A browser that was let into a gallery. Still pictures, unless a test is about moving ones: the
 * processor draws here.
 */
export class Visitor {
  static async enter(gallery, { rules, ...options } = {}) {
    const visitor = new Visitor();
    visitor.gallery = gallery;
    visitor.browser = await launch({ rules });
    try {
      visitor.context = await visitor.browser.newContext({
        viewport: wide, reducedMotion: "reduce", colorScheme: "light", ...options,
      });
      /** What went wrong on any page. */
      visitor.problems = [];
      visitor.page = await visitor.newPage();
      const answer = await visitor.page.goto(gallery.link);
      assert.equal(answer.status(), 200, "the link authorizes the browser");
      await cards(visitor.page);
    } catch (error) {
      // Nobody would close it, and Node waits for it.
      await visitor.close();
      throw error;
    }
    return visitor;
  }

  /** A page that tells what it complains of; not yet at the gallery. */
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

  /** The gallery again, at what stands behind '#' in a link. */
  async open(hash = "", page = this.page) {
    // Else a browser takes another '#' for a place on the same page.
    await page.goto("about:blank");
    await page.goto(`${this.gallery.origin}/${hash}`);
    await page.locator("#counts", { hasText: "shown" }).waitFor();
    await assertWebGl(page);
    return page;
  }

  /** Problems so far must be none but those of the pattern. */
  assertNoProblems(but = /^$/) {
    const bad = this.problems.filter((problem) => !but.test(problem));
    this.problems.length = 0;
    assert.deepEqual(bad, []);
  }

  close() { return this.browser.close(); }
}

/** Waits until the pictures are drawn of those cards that are in view; returns how many these are. */
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

/** Waits until the player shows so many animations, drawn; returns what it says of itself. */
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

/** Of a canvas' pixels: how many colours it has, and how many are not the commonest one. */
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

/** A picture for the documents, where SLEIGHT_SCREENSHOTS names a folder. */
export async function screenshotFor(page, name) {
  const folder = process.env.SLEIGHT_SCREENSHOTS;
  if (folder === undefined) return;
  const before = page.viewportSize();
  await page.setViewportSize({ width: 1280, height: 800 });
  await page.waitForTimeout(1500);
  await page.screenshot({ path: `${folder}/${name}.png` });
  if (before !== null) await page.setViewportSize(before);
}
