// Sketches of animations, for comparison: the bodies' places at equal times, and the first contacts.
// clients/browse/resemblance.h has the definition; the numbers are the same bit for bit.

import { pieceAt } from "./inside";
import type { SearchIndex } from "./search-index";

/** Number of equal times at which bodies are compared; rest is one more. */
export const EQUAL_TIMES = 64;
export const TIMES = EQUAL_TIMES + 1;
/** Number of these times at which bodies are matched: every eighth. */
export const MATCHING_TIMES = 9;
const MATCHING_STEP = (TIMES - 1) / (MATCHING_TIMES - 1);
/** Maximum number of compared first contacts. */
export const FIRST_CONTACTS_MAX = 256;
/** Fraction of the animations that are at rest by the last equal time. */
const COVERED = 0.95;
/** Larger coordinates are clamped to this, so that squared distances are finite in single precision. No
 *  scene is so large. */
const PLACE_MAX_M = 1e18;

export interface Sketch {
  /** For each body, x at all times, then y, then z, in single precision. */
  readonly places: Float32Array;
  readonly enters: Uint8Array;
  /** For each body, x, y and z at each matching time. */
  readonly matched: Float64Array;
  /** First contacts in the order of time: two features each, the lower one first. */
  readonly contacts: Uint32Array;
  /** keyOf() of the contacts, ascending, and each key's place in `contacts`. */
  readonly keys: Float64Array;
  readonly placeOfKey: Uint32Array;
}

/** The time when 95% of the animations are at rest. */
export function coveredDurationS(index: SearchIndex, entries: readonly number[]): number {
  const ends = Float64Array.from(entries, (entry) => index.endS[entry]!).sort();
  return ends.length === 0 ? 0 : ends[Math.ceil(COVERED * (ends.length - 1))]!;
}

/** Encodes two features as one number, in the order of (low, high). */
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

/** The same numbers in contiguous memory, because matching reads each of them hundreds of times. */
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
      // Before a body enters, use the place where it enters.
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
  /** Insertion order is the order of time. */
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
