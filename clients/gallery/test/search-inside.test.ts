import assert from "node:assert/strict";
import { test } from "node:test";
import type { Box, Condition } from "../src/search/condition";
import { firstInside } from "../src/search/inside";
import { find, isMet } from "../src/search/query";
import type { SearchIndex } from "../src/search/search-index";
import { Turns } from "../src/search/turns";
import { indexOf, type MadeEntry, type MadePiece, randomEntry, randomNumbers } from "./search-scene";

const SEED = 26;
/** Rounding of a place: its coordinates are some metres at most. */
const ROUNDING_M = 1e-9;

/**
 * Moments between which no coordinate passes a bound: a body is in the box at some moment exactly if it
 * is at one of these or midway between two.
 */
function momentsOf(
  { start, p, v, a }: MadePiece, fromS: number, toS: number, box: Box, marginM: number,
): number[] {
  const moments = [fromS];
  if (toS < Infinity) moments.push(toS);
  for (let axis = 0; axis < 3; ++axis) {
    for (const bound of [box[axis]! - marginM, box[axis + 3]! + marginM]) {
      const c = p[axis]! - bound;
      const square = v![axis]! ** 2 - 2 * a![axis]! * c;
      for (const sign of [-1, 1]) {
        moments.push(start - c / v![axis]!, start + (sign * Math.sqrt(square) - v![axis]!) / a![axis]!,
          start - 2 * c / (v![axis]! + sign * Math.sqrt(square)));
      }
    }
  }
  // What was divided by nothing, or has no root, is no moment.
  return moments.filter((t) => t >= fromS && t <= toS && t < Infinity).sort((x, y) => x - y);
}

function isIn({ start, p, v, a }: MadePiece, t: number, box: Box, marginM: number): boolean {
  const s = t - start;
  return p.every((_, axis) => {
    const at = p[axis]! + s * v![axis]! + 0.5 * s * s * a![axis]!;
    return at >= box[axis]! - marginM && at <= box[axis + 3]! + marginM;
  });
}

/** The first moment in the box, looked for slowly and plainly; NaN: never. */
function slowFirstInside(
  path: readonly MadePiece[], box: Box, fromS: number, toS: number, marginM = 0,
): number {
  for (const [i, piece] of path.entries()) {
    const from = Math.max(piece.start, fromS);
    const to = Math.min(path[i + 1]?.start ?? Infinity, toS);
    if (!(from <= to)) continue;
    const moments = momentsOf(piece, from, to, box, marginM);
    for (const [m, moment] of moments.entries()) {
      // Behind the last moment of a piece without an end nothing changes sides any more.
      const next = moments[m + 1] ?? (to < Infinity ? to : moment + 2);
      const middle = 0.5 * (moment + next);
      if (isIn(piece, moment, box, marginM) || isIn(piece, middle, box, marginM)) return moment;
    }
  }
  return NaN;
}

interface Asked {
  readonly box: Box;
  readonly fromS: number;
  readonly toS: number;
}

/** A box about a place where some body is at some moment; some sides are open. */
function randomAsked(entry: MadeEntry, random: () => number): Asked {
  const pieces = entry.paths.flat();
  const piece = pieces[Math.floor(pieces.length * random())]!;
  const s = 0.05 * random();
  const box = new Float64Array(6);
  for (let axis = 0; axis < 3; ++axis) {
    const middle = piece.p[axis]! + s * piece.v![axis]! + 0.5 * s * s * piece.a![axis]!;
    const side = 2 * 10 ** (-2.5 * random());
    const shift = side * (random() - 0.5);
    box[axis] = random() < 0.15 ? -Infinity : middle + shift - 0.6 * side;
    box[axis + 3] = random() < 0.15 ? Infinity : middle + shift + 0.6 * side;
  }
  const from = 1.5 * random() - 0.2;
  const isAlways = random() < 0.3;
  return {
    box,
    fromS: isAlways || random() < 0.2 ? -Infinity : from,
    toS: isAlways || random() < 0.2 ? Infinity : from + 10 ** (-3 * random()),
  };
}

async function randomCases(): Promise<{ made: MadeEntry[]; index: SearchIndex; random: () => number }> {
  const random = randomNumbers(SEED);
  const made = Array.from({ length: 500 }, (_, draw) => randomEntry(draw, random));
  return { made, index: await indexOf(made), random };
}

test("the first moment in a box is the slow one's", async () => {
  // Goal: parabolas in boxes are solved rightly. Method: 20,000 random paths and boxes; each moment at
  // which a coordinate passes a bound is tried beside. Answers that hang on the last bits are counted.
  const { made, index, random } = await randomCases();
  let met = 0;
  let close = 0;
  const asked = 20_000;
  for (let n = 0; n < asked; ++n) {
    const entry = n % made.length;
    const body = Math.floor(3 * random());
    const path = made[entry]!.paths[body]!;
    const { box, fromS, toS } = randomAsked(made[entry]!, random);
    const found = firstInside(index, 3 * entry + body, box, fromS, toS);
    const slow = slowFirstInside(path, box, fromS, toS);
    if (Number.isFinite(found)) ++met;
    if (Number.isNaN(found) ? Number.isNaN(slow) : Math.abs(found - slow) < 1e-7) continue;
    ++close;
    const wide = slowFirstInside(path, box, fromS, toS, ROUNDING_M);
    const narrow = slowFirstInside(path, box, fromS, toS, -ROUNDING_M);
    assert.ok(Number.isNaN(narrow) !== Number.isNaN(wide) || Math.abs(narrow - wide) > 1e-7,
      `case ${n} of seed ${SEED}: ${found}, slowly ${slow}`);
  }
  assert.ok(met > asked / 10 && met < 0.9 * asked, `${met} of ${asked} are met`);
  assert.ok(close < asked / 1000, `${close} of ${asked} are within rounding`);
});

test("were paths sampled, it would be seen", async () => {
  // Goal: the comparison above can fail. Method: answers at 30 frames a second, which miss what is short.
  const { made, random } = await randomCases();
  let missed = 0;
  for (let n = 0; n < 2000; ++n) {
    const path = made[n % made.length]!.paths[0]!;
    const { box } = randomAsked(made[n % made.length]!, random);
    const isSampled = Array.from({ length: 90 }, (_, frame) => frame / 30).some((t) => {
      const piece = path.filter((one) => one.start <= t).at(-1);
      return piece !== undefined && isIn(piece, t, box, 0);
    });
    if (!isSampled && !Number.isNaN(slowFirstInside(path, box, -Infinity, Infinity))) ++missed;
  }
  assert.ok(missed > 20, `${missed}`);
});

test("boxes of reach change no answer", async () => {
  // Goal: what spares looking at pieces only spares. Method: the same index with boxes of all of space.
  const { made, index, random } = await randomCases();
  const everywhere = <T extends Float64Array | Float32Array>(boxes: T): T =>
    boxes.map((_, i) => i % 6 < 3 ? -Infinity : Infinity) as T;
  const reach = { tracks: everywhere(index.reach.tracks), blocks: everywhere(index.reach.blocks) };
  const blind: SearchIndex = { ...index, reach };
  const who = { bodies: [0, 1, 2], isEvery: false, isAmong: Uint8Array.of(1, 1, 1, 0, 0, 0) };
  for (let n = 0; n < 300; ++n) {
    const { box, fromS, toS } = randomAsked(made[n]!, random);
    const when = { fromS, toS };
    const condition: Condition = { is: "inside", who: { ...who, isEvery: n % 4 === 0 }, box, when };
    const found = await find(condition, index, new Turns());
    assert.deepEqual(found, [...made.keys()].filter((entry) => isMet(condition, blind, entry)));
  }
});

test("hits are found of both sides, each body's or one's", async () => {
  // Goal: `touches` of one, any and every. Method: random hits, beside a plain look at all of them.
  const { made, index, random } = await randomCases();
  for (let n = 0; n < 3000; ++n) {
    const entry = n % made.length;
    const bodies = [[0], [1], [2], [0, 1], [0, 1, 2]][Math.floor(5 * random())]!;
    const isAmong = Uint8Array.from({ length: 6 }, (_, feature) => bodies.includes(feature) ? 1 : 0);
    const isEvery = random() < 0.5;
    const partner = random() < 0.4 ? null : Math.floor(5 * random());
    const fromS = random() < 0.5 ? -Infinity : random();
    const toS = random() < 0.5 ? Infinity : Math.max(0, fromS) + random();
    const { contacts, paths } = made[entry]!;
    const touches = (body: number): boolean => contacts.some(([time, one, two]) =>
      time >= fromS && time <= toS && ((one === body && (partner ?? two) === two) ||
        (two === body && (partner ?? one) === one)));
    const there = bodies.filter((body) => paths[body]!.length > 0);
    const slow = isEvery ? there.length > 0 && there.every(touches) : there.some(touches);
    const condition: Condition =
      { is: "touches", who: { bodies, isEvery, isAmong }, partner, when: { fromS, toS } };
    assert.equal(isMet(condition, index, entry), slow, `case ${n} of seed ${SEED}`);
  }
});
