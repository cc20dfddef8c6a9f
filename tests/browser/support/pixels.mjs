// Compares where bodies are drawn with where the C++ code computes them.
import assert from "node:assert/strict";
import { find, run, testProgram } from "./programs.mjs";

/** Maximum distance of the middle of a body's pixels from its centre. */
export const awayMaxPx = 3;

/** Measures the player's picture. For each animation: its own time, and for each body the box of pixels
 *  that differ when only this body is drawn. null: no pixels differ. */
export function measured(page, bodies) {
  return page.evaluate(async (count) => {
    // player is a snapshot, so it is requested again each time.
    const now = () => window.sleightGallery.player;
    const player = now();
    const canvas = document.querySelector("#player-canvas");
    const picture = async (only) => {
      const { frames } = now();
      player.showOnly(only);
      while (now().frames === frames || !now().isSettled) await new Promise(requestAnimationFrame);
      const bitmap = await createImageBitmap(canvas);
      const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d", { willReadFrequently: true });
      context.drawImage(bitmap, 0, 0);
      return new Uint32Array(context.getImageData(0, 0, bitmap.width, bitmap.height).data.buffer);
    };
    const { width } = canvas;
    if (width !== canvas.clientWidth) throw new Error(`${width} pixels on ${canvas.clientWidth}`);
    const cells = player.cells.map((cell) => ({ ...cell }));
    const nothing = await picture(-1);
    const boxes = cells.map(() => []);
    for (let body = 0; body < count; ++body) {
      const seen = await picture(body);
      cells.forEach((cell, index) => {
        let [low, high, left, right] = [Infinity, -Infinity, Infinity, -Infinity];
        for (let y = Math.ceil(cell.y); y < cell.y + cell.height; ++y)
          for (let x = Math.ceil(cell.x); x < cell.x + cell.width; ++x) {
            if (seen[y * width + x] === nothing[y * width + x]) continue;
            low = Math.min(low, y);
            high = Math.max(high, y + 1);
            left = Math.min(left, x);
            right = Math.max(right, x + 1);
          }
        boxes[index].push(right < left ? null : { left, right, low, high });
      });
    }
    player.showOnly(null);
    return cells.map((cell, index) => ({ cell, name: player.labels[index], t: player.ownTime(index), boxes: boxes[index] }));
  }, bodies);
}

/** Projects places to the picture: [{index, centre, radius}] -> [{x, y, radiusPx}]. */
export const onScreen = (page, places) => page.evaluate((list) => list.map(({ index, centre, radius }) =>
  window.sleightGallery.player.screenOfPlace(index, centre, radius)), places);

/** Checks that bodies of random animations are where sleight-evaluate-poses computes them: one to nine side
 *  by side, at random times, from random directions. REQUIRES: the visitor's page is dark, because no body
 *  has that colour. */
export async function judgeBodies({ visitor, world, path, asked, random }) {
  const { page } = visitor;
  const known = find(path).animations;
  const run_id = known[0].run_id;
  let bodies = 0;
  const worst = { away: 0, size: 0, words: "" };
  const counts = { animations: 0, discs: 0, cut: 0, absent: 0 };
  while (counts.animations < asked) {
    const chosen = random.some(known, random.of([1, 3, 9, 9])).slice(0, asked - counts.animations);
    // Some animations may already be at rest.
    const t = random.between(0, Math.max(...chosen.map(({ numbers }) => numbers.rest_s)));
    const camera = [random.between(-3, 3), random.between(-0.2, 1.4), random.between(0.7, 1.3)];
    const link = new URLSearchParams({
      run: run_id, view: "list", play: chosen.map(({ id }) => id).join(","), t: t.toFixed(4),
      ...(random.uniform() < 0.5 ? { camera: camera.map((value) => value.toFixed(3)).join(",") } : {}),
    });
    await page.evaluate((hash) => { location.hash = hash; }, `#${link}`);
    await page.waitForFunction((wanted) => {
      const player = window.sleightGallery.player;
      return player?.isSettled && player.labels.join() === wanted.labels && Math.abs(player.time - wanted.t) < 1e-3;
    }, { labels: chosen.map(({ id }) => id).join(), t });
    bodies ||= await page.evaluate(async (id) => {
      const { archives } = await (await fetch("/api/gallery")).json();
      const found = archives.find(({ run }) => run === id);
      const { features } = await (await fetch(`/api/archives/${found.id}/scene`)).json();
      return features.filter(({ kind }) => kind === "body").length;
    }, run_id);
    const shown = await measured(page, bodies);
    assert.deepEqual(shown.map(({ name }) => name), chosen.map(({ id }) => id));
    const questions = shown.map(({ name, t: own }) => `${name} ${own}`).join("\n");
    const answers = run(testProgram("sleight-evaluate-poses"), [path], { input: questions })
      .trim().split("\n").map((line) => JSON.parse(line));
    const places = [];
    answers.forEach(({ bodies: list }, index) => {
      assert.ok(Math.abs(shown[index].t - t) < 1e-3);
      assert.equal(list.length, bodies);
      list.forEach(({ centre_m, radius_m }, body) => {
        const box = shown[index].boxes[body];
        if (centre_m !== null) places.push({ index, body, centre: centre_m, radius: radius_m, box });
        else {
          ++counts.absent;
          assert.equal(box, null, `${shown[index].name}: body ${body} is drawn before it enters`);
        }
      });
    });
    const expected = await onScreen(page, places);
    places.forEach(({ index, body, box }, i) => {
      const { x, y, radiusPx } = expected[i];
      const { cell, name, t: own } = shown[index];
      const reach = radiusPx + awayMaxPx;
      if (x - reach < cell.x || x + reach > cell.x + cell.width || y - reach < cell.y || y + reach > cell.y + cell.height) {
        ++counts.cut;
        return;
      }
      ++counts.discs;
      const words = `${world}, seed ${random.seed}: ${name} at ${own} s, body ${body}, of ${chosen.length}`;
      assert.notEqual(box, null, `${words}: isn't drawn`);
      const away = Math.hypot((box.left + box.right) / 2 - x, (box.low + box.high) / 2 - y);
      const size = Math.max(box.right - box.left, box.high - box.low) / 2 - radiusPx;
      if (away > worst.away) Object.assign(worst, { away, words });
      worst.size = Math.max(worst.size, size);
      assert.ok(away <= awayMaxPx, `${words}: ${away} px away`);
      assert.ok(size <= awayMaxPx, `${words}: ${size} px too large`);
    });
    counts.animations += chosen.length;
  }
  console.log(`${world}, seed ${random.seed}: ${JSON.stringify(counts)}; ${worst.away.toFixed(2)} px away at most, ` +
    `${worst.size.toFixed(2)} px larger than its ball`);
  // Enough bodies were completely visible.
  assert.ok(counts.discs >= 2 * counts.cut && counts.discs >= asked / 2, JSON.stringify(counts));
  visitor.assertNoProblems();
}
