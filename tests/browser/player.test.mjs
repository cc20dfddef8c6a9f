// Goal: the player shows one to nine aligned animations, seeks to times and events, and reports its state.
// Method: play animations of a gallery in Chromium. Compare times and events with the archive's numbers, and
// compare pictures of the canvas before and after each change.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { archives } from "./support/archives.mjs";
import { inkOf, playerShows, playerState, screenshotFor } from "./support/browser.mjs";
import { Gallery } from "./support/gallery.mjs";
import { find } from "./support/programs.mjs";
import { leave, visit } from "./support/visit.mjs";

let visitor, page;
const { hi, dice } = archives();
const known = find(hi).animations;
const nine = known.slice(0, 9).map(({ id }) => id);

before(async () => ({ visitor, page } = await visit([hi, dice])));
after(leave);

const canvas = () => page.locator("#player-canvas");
const settled = () => page.waitForFunction(() => window.sleightGallery.player?.isSettled);
const time = async () => {
  await settled();
  return (await playerState(page)).time;
};
/** A checksum of the canvas's picture. */
const picture = async () => {
  await settled();
  return canvas().evaluate(async (element) => {
    const bitmap = await createImageBitmap(element);
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    let hash = 7;
    for (const pixel of new Uint32Array(context.getImageData(0, 0, bitmap.width, bitmap.height).data.buffer))
      hash = (Math.imul(hash, 31) + pixel) | 0;
    return hash;
  });
};
const near = (a, b, within = 1e-3) => assert.ok(Math.abs(a - b) <= within, `${a} is not ${b}`);

test("one animation: played from a card, by time and by events", async () => {
  await visitor.open("#view=list");
  const first = page.locator("#list [data-index='0']");
  await first.locator("canvas").dblclick();
  const { labels, range } = await playerShows(page, 1);
  const [{ id, numbers }] = known;
  assert.deepEqual(labels, [id]);
  near(range.from, 0);
  near(range.to, numbers.rest_s);
  assert.match(await page.locator("#player-title").innerText(), new RegExp(id));
  assert.ok((await inkOf(canvas())).colours > 50);
  await page.locator("#player-proportion").waitFor();
  assert.match(await page.locator("#numbers").innerText(), /log_prior/);

  // Step by frames and by events.
  await page.locator("#timeline").focus();
  await page.keyboard.press("Home");
  near(await time(), 0);
  await page.locator("#frame-on").click();
  near(await time(), 1 / 60);
  await page.locator("#frame-back").click();
  near(await time(), 0);
  await page.locator("#events summary").click();
  await page.locator("#events li").first().waitFor();
  const events = await page.locator("#events li button").allInnerTexts();
  assert.ok(events.length > 10, `${events.length} events`);
  const times = events.map((words) => Number(/^([\d.]+)\s*s/.exec(words)[1]));
  assert.deepEqual(times, [...times].sort((a, b) => a - b));
  const later = [...new Set(times.filter((t) => t > 0))];
  for (const t of later.slice(0, 3)) {
    await page.locator("#event-next").click();
    near(await time(), t);
  }
  await page.locator("#event-before").click();
  near(await time(), later[1]);
  await page.locator("#events li button").nth(8).click();
  near(await time(), times[8]);
  await page.locator("#timeline").focus();
  await page.keyboard.press("End");
  near(await time(), numbers.rest_s);

  // The player plays at the selected speed, and stops at the end.
  await page.locator("#speed").selectOption("4");
  await page.keyboard.press("Home");
  const plays = page.waitForFunction(() => window.sleightGallery.player.isPlaying);
  await page.locator("#play-pause").click();
  await plays;
  await page.waitForFunction((end) => {
    const { isPlaying, time: now } = window.sleightGallery.player;
    return !isPlaying && Math.abs(now - end) < 1e-3;
  }, numbers.rest_s);
  await page.locator("#close-player").click();
  await page.locator("#player").waitFor({ state: "hidden" });
  assert.equal(await playerState(page), null);
  visitor.assertNoProblems();
});

test("trails, marks, cameras and the ghost change the picture reversibly", async () => {
  await visitor.open(`#view=list&play=${nine[0]},${nine[1]}&t=1.2`);
  await playerShows(page, 2);
  const plain = await picture();
  for (const box of ["#trails", "#marks"]) {
    await page.locator(box).click();
    assert.notEqual(await picture(), plain, box);
    await page.locator(box).click();
    assert.equal(await picture(), plain, box);
  }
  await page.locator("#ghost").selectOption("0");
  assert.notEqual(await picture(), plain, "ghost");
  await page.locator("#ghost").selectOption("");
  assert.equal(await picture(), plain, "no ghost");
  const seen = new Set([plain]);
  for (const view of ["front", "top", "side"]) {
    await page.locator(`#camera-${view}`).click();
    seen.add(await picture());
  }
  assert.equal(seen.size, 4);
  await page.locator("#camera-home").click();
  assert.equal(await picture(), plain);
  // Turn and zoom with the pointer.
  const box = await canvas().boundingBox();
  await page.mouse.move(box.x + box.width / 4, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 4 + 60, box.y + box.height / 2, { steps: 3 });
  await page.mouse.up();
  const turned = await picture();
  assert.notEqual(turned, plain);
  const { frames } = await playerState(page);
  await page.mouse.wheel(0, -240);
  await page.waitForFunction((before) => window.sleightGallery.player.frames > before, frames);
  assert.notEqual(await picture(), turned);
  // A click on a body shows its name and place.
  await page.locator("#camera-home").click();
  await settled();
  const at = await page.evaluate(() => {
    const { player } = window.sleightGallery;
    return player.screenOf(0, 0, player.ownTime(0));
  });
  await canvas().click({ position: { x: at.x, y: at.y } });
  await page.locator("#player-hint", { hasText: /^(ball|bins|ground)/ }).waitFor();
  visitor.assertNoProblems();
});

test("nine side by side, aligned by start, first contact and end", async () => {
  await visitor.open("#view=list");
  await page.locator("#list [data-index='0']").click();
  await page.locator("#list [data-index='8']").click({ modifiers: ["Shift"] });
  await page.locator("#selection-words", { hasText: "9" }).waitFor();
  await page.locator("#compare").click();
  const { labels } = await playerShows(page, 9);
  assert.deepEqual(labels, nine);
  const cells = await page.evaluate(() => window.sleightGallery.player.cells.map((cell) => ({ ...cell })));
  assert.equal(cells.length, 9);
  cells.forEach((a, i) => cells.slice(i + 1).forEach((b) => assert.ok(
    a.x + a.width <= b.x || b.x + b.width <= a.x || a.y + a.height <= b.y || b.y + b.height <= a.y)));
  assert.equal(await page.locator(".player-label").count(), 9);
  const ownTimes = () => page.evaluate(() => window.sleightGallery.player.labels.map((_, i) =>
    window.sleightGallery.player.ownTime(i)));
  const rests = known.slice(0, 9).map(({ numbers }) => numbers.rest_s);
  await page.locator("#timeline").focus();
  await page.keyboard.press("Home");
  for (const t of await ownTimes()) near(t, 0);
  // Aligned by the end: at the shared end, all animations are at rest.
  await page.locator("#sync").selectOption("end");
  await page.waitForFunction(() => window.sleightGallery.player.range.to < 1e-9);
  await page.locator("#timeline").focus();
  await page.keyboard.press("End");
  await settled();
  (await ownTimes()).forEach((t, i) => near(t, rests[i]));
  // Aligned by the first contact: each animation is at its first hit.
  await page.locator("#sync").selectOption("contact");
  await page.waitForFunction(() => window.sleightGallery.player.range.to > 0.1);
  const hits = await page.evaluate(async (names) => {
    const packed = async (name) => {
      const bytes = await (await fetch(`/api/archives/0/animations?names=${name}`)).arrayBuffer();
      const head = new DataView(bytes).getUint32(0, true);
      const { columns } = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, head)));
      const column = (of, Type) => {
        const { offset, count } = columns.find((one) => one.name === of);
        return new Type(bytes, 4 + head + offset, count);
      };
      const cause = column("0:cause", Uint8Array);
      return Math.min(...[...column("0:start_s", Float64Array)].filter((_, i) => cause[i] === 1));
    };
    return Promise.all(names.map(packed));
  }, nine);
  await page.evaluate(() => { location.hash = location.hash.replace(/&t=[^&]*/, "") + "&t=0"; });
  await page.waitForFunction(() => Math.abs(window.sleightGallery.player.time) < 1e-9);
  (await ownTimes()).forEach((t, i) => near(t, hits[i], 1e-6));
  assert.match(await page.evaluate(() => location.hash), /sync=contact/);
  await page.locator("#sync").selectOption("start");
  await page.waitForFunction(() => window.sleightGallery.player.range.from === 0);
  await page.locator("#timeline").focus();
  for (let i = 0; i < 60; i += 15) await page.keyboard.press("PageUp");
  await settled();
  assert.ok((await inkOf(canvas())).colours > 50);
  await screenshotFor(page, "gallery_player");
  visitor.assertNoProblems();
});

test("a lost graphics context is restored", async () => {
  await visitor.open(`#view=list&play=${nine[0]}&t=0.7`);
  await playerShows(page, 1);
  const before = await picture();
  assert.ok(await page.evaluate(() => {
    window.sleightGallery.loseContext(300);
    return window.sleightGallery.renderer.isLost;
  }));
  await page.waitForFunction(() => !window.sleightGallery.renderer.isLost);
  await page.locator("#frame-on").click();
  await page.locator("#frame-back").click();
  assert.equal(await picture(), before);
  visitor.assertNoProblems(/context lost|Context Lost|context restored/i);
});
