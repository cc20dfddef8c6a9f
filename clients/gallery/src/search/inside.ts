// Finds when a body's centre is in a box, with the operations of clients/browse/inside.cpp in the same order.
//
// On each axis a piece of a path is a parabola in time, which is between two bounds in at most two time
// ranges. The centre is in the box during the intersection of the three axes' ranges. NaN means never.

import type { Box } from "./condition";
import { blockEnd, blockOf } from "./reach";
import type { SearchIndex } from "./search-index";

export const NEVER = NaN;

/** At most two ranges (from, to) per axis; scratch memory of the running function. */
const held = new Float64Array(12);
const counts = new Uint8Array(3);

/** The piece in force, the last of several with the same start; -1 before the first piece. */
export function pieceAt(startS: Float64Array, first: number, end: number, timeS: number): number {
  let low = first;
  let high = end;
  while (low < high) {
    const middle = (low + high) >>> 1;
    if (timeS < startS[middle]!) high = middle;
    else low = middle + 1;
  }
  return low > first ? low - 1 : -1;
}

/** The first moment between two times when the body is in the box. */
export function firstInside(
  index: SearchIndex, track: number, box: Box, fromS: number, toS: number,
): number {
  const { startS, reach } = index;
  const first = index.trackFirst[track]!;
  const end = first + index.trackCount[track]!;
  let piece = Math.max(first, pieceAt(startS, first, end, fromS));
  while (piece < end && startS[piece]! <= toS) {
    const block = blockOf(piece);
    if (misses(reach.blocks, 6 * block, box)) {
      piece = blockEnd(block);
      continue;
    }
    const blockStop = Math.min(end, blockEnd(block));
    for (; piece < blockStop && startS[piece]! <= toS; ++piece) {
      const endS = piece + 1 < end ? startS[piece + 1]! : Infinity;
      const found = firstInsidePiece(index, piece, endS, box, fromS, toS);
      if (found === found) return found;
    }
  }
  return NEVER;
}

/** Whether row `at` of `boxes` doesn't intersect the box. */
export function misses(boxes: Float32Array | Float64Array, at: number, box: Box): boolean {
  return !(boxes[at]! <= box[3]! && boxes[at + 1]! <= box[4]! && boxes[at + 2]! <= box[5]! &&
    box[0]! <= boxes[at + 3]! && box[1]! <= boxes[at + 4]! && box[2]! <= boxes[at + 5]!);
}

/** The first moment when one piece, which is in force until `endS`, is in the box. */
export function firstInsidePiece(
  index: SearchIndex, piece: number, endS: number, box: Box, fromS: number, toS: number,
): number {
  const startS = index.startS[piece]!;
  const s0 = max(0, fromS - startS);
  const s1 = min(endS, toS) - startS;
  if (!(s0 <= s1)) return NEVER;
  const row = 3 * index.acceleration[piece]!;
  for (let axis = 0; axis < 3; ++axis) {
    counts[axis] = 0;
    between(axis, index.positionM[3 * piece + axis]!, index.velocityMps[3 * piece + axis]!,
      index.accelerationsMps2[row + axis]!, box[axis]!, box[axis + 3]!, s0, s1);
    if (counts[axis] === 0) return NEVER;
  }
  const first = firstCommon();
  return first === first ? startS + first : NEVER;
}

/** The first moment in the intersection of the three axes' ranges. */
function firstCommon(): number {
  let first = NEVER;
  for (let x = 0; x < counts[0]!; ++x) {
    for (let y = 0; y < counts[1]!; ++y) {
      for (let z = 0; z < counts[2]!; ++z) {
        const from = max(max(held[2 * x]!, held[4 + 2 * y]!), held[8 + 2 * z]!);
        const to = min(min(held[2 * x + 1]!, held[5 + 2 * y]!), held[9 + 2 * z]!);
        if (from <= to && !(from >= first)) first = from;
      }
    }
  }
  return first;
}

/** Adds the ranges in which p + v s + a s^2 / 2 is between the bounds. */
function between(
  axis: number, p: number, v: number, a: number, low: number, high: number, s0: number, s1: number,
): void {
  if (v === 0 && a === 0) {
    if (p >= low && p <= high) add(axis, s0, s1);
    return;
  }
  const turn = a === 0 ? s0 : -v / a;
  if (turn > s0 && turn < s1) {
    addBranch(axis, p, v, a, low, high, s0, turn);
    addBranch(axis, p, v, a, low, high, turn, s1);
  } else {
    addBranch(axis, p, v, a, low, high, s0, s1);
  }
}

/** Adds the range in which a monotonic branch from s0 to s1 is between the bounds. */
function addBranch(
  axis: number, p: number, v: number, a: number, low: number, high: number, s0: number, s1: number,
): void {
  const at0 = p + s0 * (v + 0.5 * a * s0);
  const at1 = s1 < Infinity ? p + s1 * (v + 0.5 * a * s1) : (a !== 0 ? a : v) < 0 ? -Infinity : Infinity;
  if (max(at0, at1) < low || min(at0, at1) > high) return;
  const isIn0 = at0 >= low && at0 <= high;
  const isIn1 = at1 >= low && at1 <= high;
  const from = isIn0 ? s0 : crossing(p, v, a, at0 < low ? low : high, s0, s1);
  const to = isIn1 ? s1 : crossing(p, v, a, at1 < low ? low : high, s0, s1);
  add(axis, from, max(from, to));
}

/** Two branches that meet within the bounds form one range. */
function add(axis: number, from: number, to: number): void {
  const count = counts[axis]!;
  const at = 4 * axis + 2 * count;
  if (count > 0 && held[at - 1] === from) {
    held[at - 1] = to;
  } else {
    held[at] = from;
    held[at + 1] = to;
    counts[axis] = count + 1;
  }
}

/** Where a branch from s0 to s1 crosses c. REQUIRES: one end is below c, the other above. */
function crossing(p: number, v: number, a: number, c: number, s0: number, s1: number): number {
  const below = p - c;
  let s: number;
  if (a === 0) {
    s = -below / v;
  } else {
    // The roots of a/2 s^2 + v s + `below`, in the form without cancellation.
    const root = Math.sqrt(max(0, v * v - 2 * a * below));
    const isNegative = v < 0 || (v === 0 && 1 / v < 0);
    const q = -(v + (isNegative ? -root : root));
    const first = q / a;
    const second = q === 0 ? first : 2 * below / q;
    const middle = 0.5 * (s0 + s1);
    const isSecond = Number.isFinite(middle)
      ? Math.abs(second - middle) < Math.abs(first - middle) : second > first;
    s = isSecond ? second : first;
  }
  return s < s0 ? s0 : s1 < s ? s1 : s;
}

// Like std::max and std::min, these functions return the first of two equal values. Math.max and Math.min
// distinguish 0 and -0.
function max(a: number, b: number): number {
  return a < b ? b : a;
}
function min(a: number, b: number): number {
  return b < a ? b : a;
}
