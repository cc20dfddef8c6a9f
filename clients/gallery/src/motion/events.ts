// Events of an animation, for timelines, marks and lists.

import { firstPast } from "./bisection";
import type { Recording } from "./recording";
import { type Cause, CAUSES, type Mode, MODES } from "./segments";

export interface MotionEvent {
  readonly timeS: number;
  readonly body: number;
  /** The feature that was hit; -1: none. */
  readonly partner: number;
  readonly cause: Cause;
  /** How the body moves after the event. */
  readonly mode: Mode;
  /** The body's centre, in the scene's frame. */
  readonly place_m: readonly [number, number, number];
  /** Change of the body's velocity. At a hit the change points away from the partner. */
  readonly change_mps: readonly [number, number, number];
}

/** Events in the order of time, then of bodies. When two bodies collide, the recording has a segment for
 *  each; only the first body's becomes an event. */
export function eventsOf(recording: Recording): MotionEvent[] {
  const events: MotionEvent[] = [];
  for (let body = 0; body < recording.bodies; ++body) {
    const first = recording.firstSegment(body);
    for (let i = first; i < recording.endSegment(body); ++i) {
      if (!isTold(recording, body, i)) continue;
      events.push(eventOf(recording, body, i, i > first));
    }
  }
  return events.sort((a, b) => a.timeS - b.timeS || a.body - b.body);
}

function eventOf(recording: Recording, body: number, i: number, hasBefore: boolean): MotionEvent {
  const { startS, partner, cause, mode, position, velocity, acceleration } = recording.segments;
  const timeS = startS[i]!;
  const change: [number, number, number] = [0, 0, 0];
  if (hasBefore) {
    const s = timeS - startS[i - 1]!;
    for (let axis = 0; axis < 3; ++axis) {
      const before = velocity[3 * (i - 1) + axis]! + s * acceleration[3 * (i - 1) + axis]!;
      change[axis] = velocity[3 * i + axis]! - before;
    }
  }
  return {
    timeS,
    body,
    partner: partner[i]!,
    cause: CAUSES[cause[i]!] ?? "mode",
    mode: MODES[mode[i]!] ?? "flying",
    place_m: [position[3 * i]!, position[3 * i + 1]!, position[3 * i + 2]!],
    change_mps: change,
  };
}

/** False for the second body's segment of a collision. */
function isTold(recording: Recording, body: number, i: number): boolean {
  const { startS, partner, cause } = recording.segments;
  const other = partner[i]!;
  if (CAUSES[cause[i]!] !== "hit" || other < 0 || other >= body) return true;
  const t = startS[i]!;
  for (let j = recording.segmentAt(other, t); j >= recording.firstSegment(other) && j >= 0; --j) {
    if (startS[j]! < t) break;
    if (partner[j] === body && CAUSES[cause[j]!] === "hit") return false;
  }
  return true;
}

/** Time of the first hit; the animation's end if there is none. */
export function firstContactS(recording: Recording): number {
  const { count, cause, startS } = recording.segments;
  let first = recording.endS;
  for (let i = 0; i < count; ++i)
    if (CAUSES[cause[i]!] === "hit") first = Math.min(first, startS[i]!);
  return first;
}

/** Times closer than this count as equal, so that stepping between events always advances. */
const SAME_S = 1e-9;

/** The nearest of the ascending `times` after `t`; null: there is none. */
export function nextTime(times: ArrayLike<number>, t: number): number | null {
  return times[firstPast(times.length, (i) => times[i]! > t + SAME_S)] ?? null;
}

/** The nearest of the ascending `times` before `t`; null: there is none. */
export function previousTime(times: ArrayLike<number>, t: number): number | null {
  return times[firstPast(times.length, (i) => times[i]! >= t - SAME_S) - 1] ?? null;
}
