// Segments of recorded motion in columns, and their evaluation. The formulas and their order are the same as
// in common/motion/segment.{h,cpp}, so the results agree to 1e-9 m and 1e-6 rad.
//
//    Centre: c(t) = position + velocity s + acceleration s^2 / 2, where s = t - start.
//    Orientation: rotated by the angular velocity w(t) = w + a s, in the scene's frame.
//
// Functions don't allocate.

import type { Pose } from "./pose";

/** Names of the numeric codes, in their order. */
export const MODES = ["flying", "sliding", "rolling", "resting"] as const;
export const CAUSES = ["start", "hit", "mode", "rest"] as const;
export type Mode = (typeof MODES)[number];
export type Cause = (typeof CAUSES)[number];
const RESTING = 3;

/** One row per segment: vectors have three numbers, orientations four (w x y z). */
export interface Segments {
  readonly count: number;
  readonly body: Uint32Array;
  readonly startS: Float64Array;
  readonly mode: Uint8Array;
  readonly cause: Uint8Array;
  readonly partner: Int32Array;
  readonly position: Float64Array;
  readonly velocity: Float64Array;
  readonly acceleration: Float64Array;
  readonly orientation: Float64Array;
  readonly angularVelocity: Float64Array;
  readonly angularAcceleration: Float64Array;
}

/** Maximum rotation per step by the second term of the Magnus expansion. */
const SECOND_TERM_RAD = 1e-6;
/** An axis that turns by less than this fraction counts as fixed. */
const STRAIGHT = 2 ** -40;
const TURN_STEPS_MAX = 100_000;
/** Below this squared angle, sin(t/2)/t is computed by its series. */
const SERIES_SQUARE_MAX = 1e-8;

// The functions below REQUIRE: index < count, t >= the segment's start.

export function positionInto(segments: Segments, index: number, t: number, out: Pose): void {
  const { position: p, velocity: v, acceleration: a } = segments;
  const i = 3 * index;
  const s = t - segments.startS[index]!;
  const half = 0.5 * s * s;
  out.x = p[i]! + s * v[i]! + half * a[i]!;
  out.y = p[i + 1]! + s * v[i + 1]! + half * a[i + 1]!;
  out.z = p[i + 2]! + s * v[i + 2]! + half * a[i + 2]!;
}

/** Stores the velocity in x, y and z of `out`. */
export function velocityInto(segments: Segments, index: number, t: number, out: Pose): void {
  const { velocity: v, acceleration: a } = segments;
  const i = 3 * index;
  const s = t - segments.startS[index]!;
  out.x = v[i]! + s * a[i]!;
  out.y = v[i + 1]! + s * a[i + 1]!;
  out.z = v[i + 2]! + s * a[i + 2]!;
}

/** If the axis turns, uses short steps of the Magnus expansion to its second term. */
export function orientationInto(segments: Segments, index: number, t: number, out: Pose): void {
  const q = segments.orientation;
  const i = 4 * index;
  out.qw = q[i]!;
  out.qx = q[i + 1]!;
  out.qy = q[i + 2]!;
  out.qz = q[i + 3]!;
  const s = t - segments.startS[index]!;
  if (s === 0 || segments.mode[index] === RESTING) return;
  turn(segments, index, s, out);
}

function turn(segments: Segments, index: number, s: number, out: Pose): void {
  const { angularVelocity: w, angularAcceleration: a } = segments;
  const i = 3 * index;
  const wx = w[i]!, wy = w[i + 1]!, wz = w[i + 2]!;
  const ax = a[i]!, ay = a[i + 1]!, az = a[i + 2]!;
  // Constant over all steps: a x (w + a s) doesn't depend on s.
  const cx = ay * wz - az * wy;
  const cy = az * wx - ax * wz;
  const cz = ax * wy - ay * wx;
  const size = Math.sqrt(cx * cx + cy * cy + cz * cz);
  const sizes = Math.sqrt(ax * ax + ay * ay + az * az) * Math.sqrt(wx * wx + wy * wy + wz * wz);
  let steps = 1;
  if (size > STRAIGHT * sizes) {
    const stepS = Math.pow((12 * SECOND_TERM_RAD) / size, 1 / 3);
    steps = Math.min(Math.max(Math.ceil(s / stepS), 1), TURN_STEPS_MAX);
  }
  const h = s / steps;
  const cube = (h * h * h) / 12;
  let qw = out.qw, qx = out.qx, qy = out.qy, qz = out.qz;
  for (let step = 0; step < steps; ++step) {
    const middle = (step + 0.5) * h;
    const rx = h * (wx + middle * ax) + cube * cx;
    const ry = h * (wy + middle * ay) + cube * cy;
    const rz = h * (wz + middle * az) + cube * cz;
    // Composes the rotation by |r| around r: second * first.
    const square = rx * rx + ry * ry + rz * rz;
    const angle = Math.sqrt(square);
    const scale = square < SERIES_SQUARE_MAX ? 0.5 - square * (1 / 48) : Math.sin(0.5 * angle) / angle;
    const bw = Math.cos(0.5 * angle), bx = scale * rx, by = scale * ry, bz = scale * rz;
    const nw = bw * qw - bx * qx - by * qy - bz * qz;
    const nx = bw * qx + bx * qw + by * qz - bz * qy;
    const ny = bw * qy + by * qw + bz * qx - bx * qz;
    const nz = bw * qz + bz * qw + bx * qy - by * qx;
    qw = nw; qx = nx; qy = ny; qz = nz;
  }
  const length = Math.sqrt(qw * qw + qx * qx + qy * qy + qz * qz);
  out.qw = qw / length;
  out.qx = qx / length;
  out.qy = qy / length;
  out.qz = qz / length;
}
