// The motion of a whole animation: each body's segments, in the order of time.
//
// A body doesn't exist before its first segment, and its last segment has no end. Methods don't allocate, so
// they can be called at each frame.

import type { Pose } from "./pose";
import { orientationInto, positionInto, type Segments } from "./segments";

export class Recording {
  /** Number of the scene's bodies, including bodies that never enter. */
  readonly bodies: number;
  /** Time when the last body comes to rest; 0 if no body enters. */
  readonly endS: number;
  /** Time when the first body enters; 0 if no body enters. */
  readonly startS: number;
  readonly segments: Segments;
  /** Body b has segments first[b] to first[b + 1] - 1. */
  private readonly first: Uint32Array;

  /** Throws an Error if the numbers aren't a valid recording. */
  constructor(segments: Segments, bodies: number) {
    this.segments = segments;
    this.bodies = bodies;
    this.first = firstOf(segments, bodies);
    let end = 0;
    let start = Infinity;
    for (let body = 0; body < bodies; ++body) {
      if (!this.enters(body)) continue;
      end = Math.max(end, this.restOf(body));
      start = Math.min(start, this.startOf(body));
    }
    this.endS = end;
    this.startS = start === Infinity ? 0 : start;
  }

  /** The body's first segment, and the index after its last segment. */
  firstSegment(body: number): number { return this.first[body] ?? 0; }
  endSegment(body: number): number { return this.first[body + 1] ?? 0; }

  enters(body: number): boolean { return this.endSegment(body) > this.firstSegment(body); }
  /** Time when the body enters. REQUIRES: the body enters. */
  startOf(body: number): number { return this.segments.startS[this.firstSegment(body)] ?? 0; }
  /** Start of the body's last segment. REQUIRES: the body enters. */
  restOf(body: number): number { return this.segments.startS[this.endSegment(body) - 1] ?? 0; }

  /** The segment in force at t, the last of several with the same start; -1 before the body enters. */
  segmentAt(body: number, t: number): number {
    const starts = this.segments.startS;
    const begin = this.firstSegment(body);
    let low = begin;
    let high = this.endSegment(body);
    // Binary search for the first segment that starts after t.
    while (low < high) {
      const middle = (low + high) >>> 1;
      if (t < starts[middle]!) high = middle;
      else low = middle + 1;
    }
    return low === begin ? -1 : low - 1;
  }

  /** If the body hasn't entered, returns false and leaves `out` unchanged. */
  poseAt(body: number, t: number, out: Pose): boolean {
    const index = this.segmentAt(body, t);
    if (index < 0) return false;
    positionInto(this.segments, index, t, out);
    orientationInto(this.segments, index, t, out);
    return true;
  }

  /** Sets only x, y and z of `out`. */
  centreAt(body: number, t: number, out: Pose): boolean {
    const index = this.segmentAt(body, t);
    if (index < 0) return false;
    positionInto(this.segments, index, t, out);
    return true;
  }

  /** Whether no body ever moves along y. */
  isPlanar(): boolean {
    const { count, velocity, acceleration } = this.segments;
    for (let i = 0; i < count; ++i)
      if (velocity[3 * i + 1] !== 0 || acceleration[3 * i + 1] !== 0) return false;
    return count > 0;
  }
}

function firstOf(segments: Segments, bodies: number): Uint32Array {
  const first = new Uint32Array(bodies + 1);
  const { count, body, startS } = segments;
  for (let i = 0; i < count; ++i) {
    const of = body[i]!;
    if (of >= bodies) throw new Error(`a segment is for body ${of + 1} of ${bodies}`);
    if (!Number.isFinite(startS[i]!)) throw new Error("a segment's start is not a finite number");
    if (i > 0 && (of < body[i - 1]! || (of === body[i - 1] && startS[i]! < startS[i - 1]!)))
      throw new Error("segments are not in order");
    first[of + 1] = i + 1;
  }
  // Bodies that don't enter have no segments.
  for (let b = 1; b <= bodies; ++b) first[b] = Math.max(first[b]!, first[b - 1]!);
  return first;
}
