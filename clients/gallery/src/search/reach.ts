// Bounding boxes of paths: one per body of each animation, and one per block of pieces.
//
// Boxes of bodies equal those of measure_reach (clients/browse/index.cpp) bit for bit, because they decide
// answers. Boxes of blocks exist only on this page: they skip pieces that cannot match.

import type { Columns } from "./search-index";
import type { Turns } from "./turns";

/** Relative rounding error by which a place may be outside its piece's box. */
const ROUNDING = 1e-12;
/** Log2 of the number of pieces per block. */
const BLOCK_SHIFT = 3;
/** Relative rounding error of boxes stored in single precision. */
const SINGLE_ROUNDING = 1e-6;
/** Maximum size (metres) of a path's terms for which rounding (1e-16 of the terms) is far below
 *  SINGLE_ROUNDING. Larger pieces, which no real path has, get a block box of all space. */
const TERM_MAX_M = 1e6;

export interface Reach {
  /** Per track: low x, y, z, high x, y, z; empty (infinity to -infinity) if the track has no pieces. */
  readonly tracks: Float64Array;
  /** Box of pieces 8 k to 8 k + 7, regardless of their bodies. */
  readonly blocks: Float32Array;
}

export function blockOf(piece: number): number {
  return piece >>> BLOCK_SHIFT;
}
export function blockEnd(block: number): number {
  return (block + 1) << BLOCK_SHIFT;
}

export async function measureReach(columns: Columns, turns: Turns): Promise<Reach> {
  const { trackFirst, trackCount, startS } = columns;
  const tracks = new Float64Array(6 * trackFirst.length);
  const blocks = emptyBoxes(new Float32Array(6 * (blockOf(startS.length) + 1)));
  emptyBoxes(tracks);
  for (let track = 0; track < trackFirst.length; ++track) {
    const first = trackFirst[track]!;
    const end = first + trackCount[track]!;
    for (let piece = first; piece < end; ++piece) {
      const durationS = piece + 1 < end ? startS[piece + 1]! - startS[piece]! : Infinity;
      for (let axis = 0; axis < 3; ++axis) {
        const isPlain = reachOf(columns, piece, axis, durationS);
        widen(tracks, 6 * track + axis, span[0]!, span[1]!);
        const low = isPlain ? span[0]! : -Infinity;
        const high = isPlain ? span[1]! : Infinity;
        widenOutwards(blocks, 6 * blockOf(piece) + axis, low, high);
      }
    }
    if (turns.isDue()) await turns.take();
  }
  return { tracks, blocks };
}

function emptyBoxes<T extends Float64Array | Float32Array>(boxes: T): T {
  boxes.fill(Infinity);
  for (let at = 3; at < boxes.length; at += 6) boxes[at] = boxes[at + 1] = boxes[at + 2] = -Infinity;
  return boxes;
}

/** Result of reachOf(): low, high. */
const span = new Float64Array(2);

/** Computes one coordinate's range, with a margin, until the piece ends after `durationS`. Returns false if
 *  the terms are so large that rounding may exceed the margin. */
function reachOf(columns: Columns, piece: number, axis: number, durationS: number): boolean {
  const p = columns.positionM[3 * piece + axis]!;
  const v = columns.velocityMps[3 * piece + axis]!;
  const a = columns.accelerationsMps2[3 * columns.acceleration[piece]! + axis]!;
  span[0] = Infinity;
  span[1] = -Infinity;
  include(p, p);
  if (v === 0 && a === 0) return Math.abs(p) <= TERM_MAX_M;
  // The last piece has no end, so its range is unlimited if it moves.
  const end = durationS < Infinity ? p + durationS * (v + 0.5 * a * durationS)
    : (a !== 0 ? a : v) < 0 ? -Infinity : Infinity;
  include(end < p ? end : p, p < end ? end : p);
  const turnS = a === 0 ? 0 : -v / a;
  if (turnS > 0 && turnS < durationS) {
    const top = p + turnS * (v + 0.5 * a * turnS);
    include(top, top);
  }
  const terms = Math.abs(p) + durationS * (Math.abs(v) + Math.abs(a) * durationS);
  return terms <= TERM_MAX_M;
}

function include(low: number, high: number): void {
  const size = larger(larger(1, Math.abs(low)), Math.abs(high));
  const margin = ROUNDING * size;
  if (low - margin < span[0]!) span[0] = low - margin;
  if (span[1]! < high + margin) span[1] = high + margin;
}

function larger(a: number, b: number): number {
  return a < b ? b : a;
}

function widen(boxes: Float64Array, at: number, low: number, high: number): void {
  if (low < boxes[at]!) boxes[at] = low;
  if (boxes[at + 3]! < high) boxes[at + 3] = high;
}

function widenOutwards(boxes: Float32Array, at: number, low: number, high: number): void {
  const outLow = low - SINGLE_ROUNDING * larger(1, Math.abs(low));
  const outHigh = high + SINGLE_ROUNDING * larger(1, Math.abs(high));
  if (outLow < boxes[at]!) boxes[at] = outLow;
  if (boxes[at + 3]! < outHigh) boxes[at + 3] = outHigh;
}
