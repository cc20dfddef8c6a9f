// Finds where two animations start to differ: the first shared time at which some body's places differ.
//
// Between the starts of segments both centres are quadratic in time, so their distance changes by at most |v|
// h + |a| h^2 / 2 within h. The steps are chosen by this bound, so no difference is missed. A body that is in
// only one animation differs once it is further than the tolerance from where it entered.

import { Pose } from "./pose";
import type { Recording } from "./recording";
import { positionInto, velocityInto } from "./segments";

export interface Shifted {
  readonly recording: Recording;
  /** Own time = shared time + shift (sync.ts). */
  readonly shift: number;
}

/** Minimum step, which is also the accuracy of the result. */
const STEP_S_MIN = 1e-5;
/** Maximum steps per body of a pair; differences after that aren't found. */
const STEPS_MAX = 200_000;

const placeA = new Pose();
const placeB = new Pose();
const velocityA = new Pose();
const velocityB = new Pose();

/** null: the animations never differ. REQUIRES: toleranceM > 0. */
export function whereTheyPart(a: Shifted, b: Shifted, toleranceM: number): number | null {
  const end = Math.max(a.recording.endS - a.shift, b.recording.endS - b.shift);
  let first = Infinity;
  const bodies = Math.max(a.recording.bodies, b.recording.bodies);
  for (let body = 0; body < bodies; ++body)
    first = Math.min(first, bodyParts(a, b, body, toleranceM, Math.min(first, end)));
  return first === Infinity ? null : first;
}

/** Infinity: no difference by `until`. */
function bodyParts(a: Shifted, b: Shifted, body: number, tolerance: number, until: number): number {
  const inA = body < a.recording.bodies && a.recording.enters(body);
  const inB = body < b.recording.bodies && b.recording.enters(body);
  if (!inA && !inB) return Infinity;
  if (!inA) return leaves(b, body, tolerance, until);
  if (!inB) return leaves(a, body, tolerance, until);
  const startA = a.recording.startOf(body) - a.shift;
  const startB = b.recording.startOf(body) - b.shift;
  const together = Math.max(startA, startB);
  if (startA !== startB) {
    const alone = leaves(startA < startB ? a : b, body, tolerance, Math.min(until, together));
    if (alone < Infinity) return alone;
  }
  return advance(a, b, body, together, tolerance, until);
}

/** The time when a body is first further than `tolerance` from where it entered. */
function leaves(of: Shifted, body: number, tolerance: number, until: number): number {
  return advance(of, null, body, of.recording.startOf(body) - of.shift, tolerance, until);
}

/** The time when the body is first further than `tolerance` from the other animation's body; if `b` is
 *  null, from where the body entered. */
function advance(
  a: Shifted, b: Shifted | null, body: number, from: number, tolerance: number, until: number,
): number {
  const { segments } = a.recording;
  const entry = 3 * a.recording.firstSegment(body);
  let t = from;
  for (let step = 0; step < STEPS_MAX && t <= until; ++step) {
    // Rounding of t - shift + shift must not yield a time before the body's start.
    const ta = Math.max(t + a.shift, a.recording.startOf(body));
    const ia = a.recording.segmentAt(body, ta);
    positionInto(segments, ia, ta, placeA);
    velocityInto(segments, ia, ta, velocityA);
    let border = borderAfter(a, body, ia);
    let ax = segments.acceleration[3 * ia]!;
    let ay = segments.acceleration[3 * ia + 1]!;
    let az = segments.acceleration[3 * ia + 2]!;
    if (b === null) {
      placeB.x = segments.position[entry]!;
      placeB.y = segments.position[entry + 1]!;
      placeB.z = segments.position[entry + 2]!;
      velocityB.x = velocityB.y = velocityB.z = 0;
    } else {
      const tb = Math.max(t + b.shift, b.recording.startOf(body));
      const ib = b.recording.segmentAt(body, tb);
      positionInto(b.recording.segments, ib, tb, placeB);
      velocityInto(b.recording.segments, ib, tb, velocityB);
      border = Math.min(border, borderAfter(b, body, ib));
      ax -= b.recording.segments.acceleration[3 * ib]!;
      ay -= b.recording.segments.acceleration[3 * ib + 1]!;
      az -= b.recording.segments.acceleration[3 * ib + 2]!;
    }
    const room = tolerance - Math.hypot(placeA.x - placeB.x, placeA.y - placeB.y, placeA.z - placeB.z);
    if (room < 0) return t;
    const speed = Math.hypot(
      velocityA.x - velocityB.x, velocityA.y - velocityB.y, velocityA.z - velocityB.z,
    );
    const safe = timeFor(room, speed, Math.hypot(ax, ay, az));
    // A segment's formula is valid only up to the next segment's start. Rounding can leave t just before a
    // border that it has reached.
    t = border > t ? Math.min(t + Math.max(safe, STEP_S_MIN), border) : t + STEP_S_MIN;
  }
  return Infinity;
}

/** The shared time when the segment ends; infinite for the last segment. */
function borderAfter(of: Shifted, body: number, index: number): number {
  const { recording, shift } = of;
  return index + 1 < recording.endSegment(body) ? recording.segments.startS[index + 1]! - shift : Infinity;
}

/** The smallest h > 0 with speed h + acceleration h^2 / 2 = distance. */
function timeFor(distance: number, speed: number, acceleration: number): number {
  if (distance <= 0) return 0;
  const root = Math.sqrt(speed * speed + 2 * acceleration * distance);
  return speed + root > 0 ? (2 * distance) / (speed + root) : Infinity;
}
