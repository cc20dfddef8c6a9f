// Of an animation what is compared: where its bodies are at equal times, and who met first.
// clients/browse/resemblance.h has the definition; numbers are the same, bit for bit.

import { pieceAt } from "./inside";
import type { SearchIndex } from "./search-index";

/** Equal times at which bodies are compared; one more at rest. */
export const EQUAL_TIMES = 64;
export const TIMES = EQUAL_TIMES + 1;
/** Of the equal times and the rest, those at which bodies are matched: every eighth. */
export const MATCHING_TIMES = 9;
const MATCHING_STEP = (TIMES - 1) / (MATCHING_TIMES - 1);
/** First contacts that are compared, at most. */
export const FIRST_CONTACTS_MAX = 256;
/** Of all rest times, the part that the equal times reach. */
const COVERED = 0.95;
/**
 * Places beyond it are taken for it, so that squares of their distances are finite in single precision: no
 * scene is so large.
 */
const PLACE_MAX_M = 1e18;

export interface Sketch {
  /** Of each body its x at all times, then y, then z: single precision is what is compared. */
  readonly places: Float32Array;
  readonly enters: Uint8Array;
  /** Of each body x, y and z at one of these times after another: those at which bodies are matched. */
  readonly matched: Float64Array;
  /** First contacts in the order of time: two features each, the lower one first. */
  readonly contacts: Uint32Array;
  /** keyOf() of the same, ascending, and where each stands among them. */
  readonly keys: Float64Array;
  readonly placeOfKey: Uint32Array;
}

/** When 19 in 20 of the animations are at rest. */
export function coveredDurationS(index: SearchIndex, entries: readonly number[]): number {
  const ends = Float64Array.from(entries, (entry) => index.endS[entry]!).sort();
  return ends.length === 0 ? 0 : ends[Math.ceil(COVERED * (ends.length - 1))]!;
}

/** Two features as one number, in the order of (low, high). */
export function keyOf(low: number, high: number, features: number): number {
  return low * features + high;
}

export function sketchOf(index: SearchIndex, entry: number, durationS: number): Sketch {
  const places = new Float32Array(3 * TIMES * index.bodies);
  const enters = new Uint8Array(index.bodies);
  for (let body = 0; body < index.bodies; ++body) {
    const track = index.bodies * entry + body;
    if (index.trackCount[track] === 0) continue;
    enters[body] = 1;
    addPlaces(index, track, durationS, places, 3 * TIMES * body);
  }
  return { places, enters, matched: matchedOf(places, index.bodies), ...contactsOf(index, entry) };
}

/** The same numbers, close to one another: matching looks at each of them hundreds of times. */
function matchedOf(places: Float32Array, bodies: number): Float64Array {
  const matched = new Float64Array(3 * MATCHING_TIMES * bodies);
  let to = 0;
  for (let body = 0; body < bodies; ++body) {
    for (let time = 0; time < TIMES; time += MATCHING_STEP) {
      for (let axis = 0; axis < 3; ++axis) matched[to++] = places[TIMES * (3 * body + axis) + time]!;
    }
  }
  return matched;
}

function addPlaces(
  index: SearchIndex, track: number, durationS: number, places: Float32Array, at: number,
): void {
  const { startS, positionM, velocityMps, accelerationsMps2 } = index;
  const first = index.trackFirst[track]!;
  const end = first + index.trackCount[track]!;
  for (let i = 0; i < EQUAL_TIMES; ++i) {
    const timeS = durationS * i / (EQUAL_TIMES - 1);
    const piece = pieceAt(startS, first, end, timeS);
    if (piece < 0) {
      // It has not entered: it is where it will.
      for (let axis = 0; axis < 3; ++axis) places[at + axis * TIMES + i] = placeOf(positionM[3 * first + axis]!);
      continue;
    }
    const s = timeS - startS[piece]!;
    const half = 0.5 * s;
    const row = 3 * index.acceleration[piece]!;
    for (let axis = 0; axis < 3; ++axis) {
      const column = 3 * piece + axis;
      places[at + axis * TIMES + i] =
        placeOf(positionM[column]! + s * (velocityMps[column]! + half * accelerationsMps2[row + axis]!));
    }
  }
  for (let axis = 0; axis < 3; ++axis)
    places[at + axis * TIMES + EQUAL_TIMES] = placeOf(positionM[3 * (end - 1) + axis]!);
}

function placeOf(xM: number): number {
  return Math.max(-PLACE_MAX_M, Math.min(xM, PLACE_MAX_M));
}

function contactsOf(
  index: SearchIndex, entry: number,
): { contacts: Uint32Array; keys: Float64Array; placeOfKey: Uint32Array } {
  const { contactBody, contactPartner } = index;
  const features = index.features.length;
  /** In the order of insertion: that of time. */
  const seen = new Map<number, number>();
  for (let at = index.contactFirst[entry]!; at < index.contactFirst[entry + 1]!; ++at) {
    if (seen.size === FIRST_CONTACTS_MAX) break;
    const body = contactBody[at]!;
    const partner = contactPartner[at]!;
    const key = body < partner ? keyOf(body, partner, features) : keyOf(partner, body, features);
    if (!seen.has(key)) seen.set(key, seen.size);
  }
  const contacts = new Uint32Array(2 * seen.size);
  for (const [key, place] of seen) {
    contacts[2 * place] = Math.floor(key / features);
    contacts[2 * place + 1] = key % features;
  }
  const keys = Float64Array.from(seen.keys()).sort();
  return { contacts, keys, placeOfKey: Uint32Array.from(keys, (key) => seen.get(key)!) };
}
