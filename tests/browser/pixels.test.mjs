// Goal: each body is drawn where the C++ code computes it. Method: show random animations of each world, one
// to nine side by side, at random times and from random directions. Draw each body alone. Compare the middle
// of its pixels with the centre that the C++ code computes (sleight-evaluate-poses), in the page's
// projection. Use 40 animations per world, or 200 with SLEIGHT_FULL=1.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { archives } from "./support/archives.mjs";
import { playerShows, Visitor } from "./support/browser.mjs";
import { Gallery } from "./support/gallery.mjs";
import { awayMaxPx, judgeBodies, measured, onScreen } from "./support/pixels.mjs";
import { find, run, testProgram } from "./support/programs.mjs";
import { Random } from "./support/random.mjs";

const asked = process.env.SLEIGHT_FULL === "1" ? 200 : 40;
const random = new Random();

let gallery, visitor, page;
const paths = archives();

before(async () => {
  gallery = await Gallery.start(Object.values(paths));
  // Dark theme: no body has the background's colour.
  visitor = await Visitor.enter(gallery, { colorScheme: "dark", viewport: { width: 1600, height: 1000 } });
  page = visitor.page;
});
after(async () => {
  await visitor?.close();
  await gallery?.stop();
});

for (const [world, path] of Object.entries(paths))
  test(`${world}: bodies are where they should be`, () => judgeBodies({ visitor, world, path, asked, random }));

test("misplaced bodies would be detected", async () => {
  const [one] = find(paths.ball).animations;
  await visitor.open(`#run=${one.run_id}&view=list&play=${one.id}&t=0.3`);
  await playerShows(page, 1);
  const [{ boxes: [box], t }] = await measured(page, 1);
  // The body's place 0.02 s earlier.
  const before = JSON.parse(run(testProgram("sleight-evaluate-poses"), [paths.ball], { input: `${one.id} ${t - 0.02}` }));
  const [{ centre_m, radius_m }] = before.bodies;
  const [{ x, y }] = await onScreen(page, [{ index: 0, centre: centre_m, radius: radius_m }]);
  assert.ok(Math.hypot((box.left + box.right) / 2 - x, (box.low + box.high) / 2 - y) > awayMaxPx);
});

test("the screen shows what was measured", async () => {
  const [one] = find(paths.hi).animations;
  await visitor.open(`#view=list&play=${one.id}&t=0.5`);
  await playerShows(page, 1);
  const canvas = page.locator("#player-canvas");
  const image = (await canvas.screenshot()).toString("base64");
  const differing = await canvas.evaluate(async (element, base64) => {
    const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const pictures = [await createImageBitmap(new Blob([bytes], { type: "image/png" })), await createImageBitmap(element)];
    const [a, b] = pictures.map((bitmap) => {
      const context = new OffscreenCanvas(element.clientWidth, element.clientHeight).getContext("2d");
      context.drawImage(bitmap, 0, 0);
      return context.getImageData(0, 0, element.clientWidth, element.clientHeight).data;
    });
    let count = 0;
    for (let i = 0; i < a.length; ++i) if (Math.abs(a[i] - b[i]) > 8) ++count;
    return count / a.length;
  }, image);
  // Only the element's rounded corners and edges differ.
  assert.ok(differing < 0.01, `${differing} of the pixels differ`);
  visitor.assertNoProblems();
});
