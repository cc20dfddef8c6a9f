// Finds an animation from a memory, as a person does who uses such scenes daily: with the page's own controls
// and by looking at pictures. The script never reads an animation's name, and has no other access to the
// archive.
//
// The person knows that balls fall in the order of their numbers, with colours from violet to yellow in that
// order.
import { looksLike } from "./looking.mjs";

const ballCount = 16;
/** With at most this many pictures left, the script looks at them instead of adding conditions. */
const looksMax = 12;

/** Returns true if the player shows a matching animation; false if none was found. */
export async function find(page, hands, memory) {
  hands.think();
  await hands.choose(page.locator("#built-kind"), "ends");
  let left = Infinity;
  for (const rest of restsKnown(memory)) {
    if (left > looksMax) left = await keepEnding(page, hands, rest);
  }
  if (left > looksMax) left = await keepMeeting(page, hands, memory.contact);
  return left > 0 && lookThrough(page, hands, memory, left);
}

/** Balls whose places are remembered reliably: {ball, column, row}, the most reliable first. */
function restsKnown({ rests, first, last }) {
  const known = [{ ball: ballCount, ...last }, { ball: 1, ...first }];
  // Of two yellow balls one fell last, so the other one fell before it.
  const other = rests.find(({ word, ...bin }) => word === "yellow" && !isSame(bin, last));
  if (other !== undefined) known.push({ ball: ballCount - 1, ...other });
  return known;
}

function isSame(a, b) {
  return a.column === b.column && a.row === b.row;
}

/** Keeps animations in which the ball ends there; returns how many are left. */
function keepEnding(page, hands, { ball, column, row }) {
  return keep(page, hands, async () => {
    hands.think();
    await hands.click(page.locator(`.swatch[data-body="ball ${ball}"]`));
    hands.think();
    const map = page.locator(".place-map");
    const { width, height } = await map.boundingBox();
    // The map is as wide and as high as the letters: columns and rows 2 to 6.
    const position = { x: ((column - 1.5) / 5) * width, y: ((6.5 - row) / 5) * height };
    await hands.click(map, { position });
  }, page.locator("#built-in"));
}

/** Keeps animations in which any body is at this place at this time. */
function keepMeeting(page, hands, { xMm, yMm, atS }) {
  return keep(page, hands, async () => {
    hands.think();
    await hands.choose(page.locator("#built-kind"), "in");
    const fill = async (label, value) => {
      hands.think();
      await hands.click(page.getByLabel(label, { exact: true }));
      await hands.type(short(value));
    };
    await fill("x from in mm", xMm - 5);
    await hands.press("Tab");
    await hands.type(short(xMm + 5));
    await fill("y from in mm", yMm - 5);
    await hands.press("Tab");
    await hands.type(short(yMm + 5));
    hands.think();
    await hands.click(page.locator(".step summary"));
    await fill("time from in s", atS - 0.1);
    await hands.press("Tab");
    await hands.type(short(atS + 0.1));
  }, page.locator("#built-in"));
}

function short(value) {
  return String(Math.round(value * 10) / 10);
}

/** Builds and applies a condition; returns how many animations are left. */
async function keep(page, hands, build, button) {
  const before = await page.locator("#chips .chip").count();
  await build();
  hands.think();
  await hands.click(button);
  await hands.wait(() => page.locator("#chips .chip-counts", { hasText: "left" }).nth(before).waitFor());
  const words = await hands.wait(() => page.locator("#counts").innerText());
  hands.think();
  return Number(/^([\d,]+) of/.exec(words)[1].replaceAll(",", ""));
}

async function lookThrough(page, hands, memory, left) {
  // Before the list appears, because a card drawn while moving would be looked at while it moves.
  if ((await page.locator("#cards-moving").getAttribute("aria-pressed")) === "true") {
    hands.think();
    await hands.click(page.locator("#cards-moving"));
  }
  hands.think();
  await hands.click(page.locator("#view-list"));
  const list = page.locator("#list");
  for (let index = 0; index < left; index++) {
    const card = list.locator(`[role=gridcell][data-index="${index}"]`);
    if (!(await isInView(card))) await hands.turnWheel(list, (await list.boundingBox()).height * 0.75);
    const canvas = card.locator("canvas");
    await hands.wait(() => canvas.and(page.locator("[data-thumbnail=drawn]")).waitFor());
    hands.look();
    if (!(await looksLike(canvas, memory.rests))) continue;
    await hands.click(card.locator("canvas"), { clickCount: 2 });
    await hands.wait(() => page.waitForFunction(() => window.sleightGallery?.player?.labels.length === 1));
    return true;
  }
  return false;
}

async function isInView(card) {
  if ((await card.count()) === 0) return false;
  const box = await card.locator("canvas").boundingBox();
  const grid = await card.page().locator("#list").boundingBox();
  return box !== null && box.y >= grid.y - 2 && box.y + box.height <= grid.y + grid.height + 2;
}
