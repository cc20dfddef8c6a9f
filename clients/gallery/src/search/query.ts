// Finds the animations of an index that match a query, as clients/browse/query.cpp does.

import { firstPast } from "../motion/bisection";
import { type Bodies, type Condition, type Inside, type Moment, type Touches } from "./condition";
import { firstInside, misses, NEVER } from "./inside";
import type { SearchIndex } from "./search-index";
import type { Turns } from "./turns";

/** Matching entries, ascending. REQUIRES: the condition was parsed for this index. */
export async function find(condition: Condition, index: SearchIndex, turns: Turns): Promise<number[]> {
  const found: number[] = [];
  for (let entry = 0; entry < index.entries; ++entry) {
    if (isMet(condition, index, entry)) found.push(entry);
    if (turns.isDue()) await turns.take();
  }
  return found;
}

export function isMet(condition: Condition, index: SearchIndex, entry: number): boolean {
  switch (condition.is) {
    case "inside":
    case "touches":
      return isEverMet(condition, index, entry);
    case "ends":
      return firstOf(condition.who, index, entry, (track) => restIn(index, track, condition.box)) !== null;
    case "number": {
      const number = index.numbers[condition.number]![entry]!;
      // Comparisons with NaN are false: animations without the number don't match.
      const isAbove = condition.isLowOpen ? number > condition.low : number >= condition.low;
      const isBelow = condition.isHighOpen ? number < condition.high : number <= condition.high;
      return isAbove && isBelow;
    }
    case "order":
      return isMetInOrder(condition.steps, index, entry);
    case "all":
      return condition.parts.every((part) => isMet(part, index, entry));
    case "any":
      return condition.parts.some((part) => isMet(part, index, entry));
    case "not":
      return !isMet(condition.part, index, entry);
  }
}

/** The end of the previous step. The next step can hold only from this time on. A hit counts for one step
 *  only, so the next step's hit must be later than the last hit. */
interface After {
  readonly timeS: number;
  readonly hitS: number;
}
const FROM_THE_BEGINNING: After = { timeS: -Infinity, hitS: -Infinity };

/** Time doesn't matter; stop at the first matching body. */
function isEverMet(moment: Moment, index: SearchIndex, entry: number): boolean {
  if (moment.is === "touches" || moment.who.isEvery)
    return firstMet(moment, index, entry, FROM_THE_BEGINNING) !== null;
  return moment.who.bodies.some((body) => {
    const met = insideOf(moment, index, index.bodies * entry + body, FROM_THE_BEGINNING);
    return met === met;
  });
}

/** Finds the earliest moment of each step in turn. Choosing later moments for earlier steps can never help. */
function isMetInOrder(steps: readonly Moment[], index: SearchIndex, entry: number): boolean {
  let after = FROM_THE_BEGINNING;
  for (const step of steps) {
    const met = firstMet(step, index, entry, after);
    if (met === null) return false;
    after = { timeS: met, hitS: step.is === "touches" ? met : after.hitS };
  }
  return true;
}

function firstMet(moment: Moment, index: SearchIndex, entry: number, after: After): number | null {
  const { who } = moment;
  if (moment.is === "inside")
    return firstOf(who, index, entry, (track) => insideOf(moment, index, track, after));
  // Hits are in the order of time, so the first match is the earliest.
  if (!who.isEvery) return hitOf(moment, who.isAmong, index, entry, after);
  const isIt = new Uint8Array(who.isAmong.length);
  return firstOf(who, index, entry, (_, body) => {
    isIt.fill(0);
    isIt[body] = 1;
    return hitOf(moment, isIt, index, entry, after) ?? NEVER;
  });
}

/** The earliest time for one of the bodies. For "every": the latest of the bodies' earliest times. */
function firstOf(
  who: Bodies, index: SearchIndex, entry: number, firstOfBody: (track: number, body: number) => number,
): number | null {
  let found: number | null = null;
  for (const body of who.bodies) {
    const track = index.bodies * entry + body;
    if (index.trackCount[track] === 0) continue;
    const first = firstOfBody(track, body);
    const isNever = first !== first;
    if (isNever && who.isEvery) return null;
    if (isNever) continue;
    if (found === null || (who.isEvery ? found < first : first < found)) found = first;
  }
  return found;
}

function insideOf(inside: Inside, index: SearchIndex, track: number, after: After): number {
  if (misses(index.reach.tracks, 6 * track, inside.box)) return NEVER;
  const fromS = Math.max(inside.when.fromS, after.timeS);
  return firstInside(index, track, inside.box, fromS, inside.when.toS);
}

/** The time when one of these bodies first makes the requested hit. */
function hitOf(
  touches: Touches, isAmong: Uint8Array, index: SearchIndex, entry: number, after: After,
): number | null {
  const { contactTimeS, contactBody, contactPartner } = index;
  const { partner: asked, when } = touches;
  const end = index.contactFirst[entry + 1]!;
  const fromS = Math.max(when.fromS, after.timeS);
  let at = index.contactFirst[entry]!;
  if (fromS > -Infinity) {
    const first = at;
    at += firstPast(end - first, (i) => contactTimeS[first + i]! >= fromS);
  }
  for (; at < end; ++at) {
    const body = contactBody[at]!;
    const partner = contactPartner[at]!;
    // A hit of two bodies counts for both, even though it is recorded for only one of them.
    const isOfBody = isAmong[body] === 1 && (asked === null || asked === partner);
    const isOfPartner = isAmong[partner] === 1 && (asked === null || asked === body);
    const isHit = (isOfBody && enters(index, entry, body)) || (isOfPartner && enters(index, entry, partner));
    if (!isHit || contactTimeS[at]! <= after.hitS) continue;
    return contactTimeS[at]! <= when.toS ? contactTimeS[at]! : null;
  }
  return null;
}

function enters(index: SearchIndex, entry: number, body: number): boolean {
  return index.trackCount[index.bodies * entry + body] !== 0;
}

/** The time when a body comes to rest in the box: the start of its last piece. */
function restIn(index: SearchIndex, track: number, box: Float64Array): number {
  const last = index.trackFirst[track]! + index.trackCount[track]! - 1;
  for (let axis = 0; axis < 3; ++axis) {
    const place = index.positionM[3 * last + axis]!;
    if (!(place >= box[axis]! && place <= box[axis + 3]!)) return NEVER;
  }
  return index.startS[last]!;
}
