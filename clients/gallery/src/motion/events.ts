// What happens in an animation, for timelines, marks and lists.

import type { Recording } from "./recording";
import { type Cause, CAUSES, type Mode, MODES } from "./segments";

export interface MotionEvent {
  readonly timeS: number;
  readonly body: number;
  /** The feature that was hit; -1: none. */
  readonly partner: number;
  readonly cause: Cause;
  /** How the body moves from then on. */
  readonly mode: Mode;
  /** Of the body's centre, in the scene's frame. */
  readonly place_m: readonly [number, number, number];
  /** By how much the body's velocity changed: at a hit it points away from the partner. */
  readonly change_mps: readonly [number, number, number];
}

/**
 * In the order of time, then of bodies. Where two bodies hit one another the recording has a
 * segment of both; the event is the first body's.
 */
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

/** False of the second half of a hit of two bodies. */
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

/** When something is first hit; the end where nothing ever is. */
export function firstContactS(recording: Recording): number {
  const { count, cause, startS } = recording.segments;
  let first = recording.endS;
  for (let i = 0; i < count; ++i)
    if (CAUSES[cause[i]!] === "hit") first = Math.min(first, startS[i]!);
  return first;
}

/** Times closer than this are one: steps from event to event must not stand still. */
const SAME_S = 1e-9;

/** The nearest time after `t`, of ascending times; null: there is none. */
export function nextTime(times: ArrayLike<number>, t: number): number | null {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >>> 1;
    if (times[middle]! > t + SAME_S) high = middle;
    else low = middle + 1;
  }
  return low < times.length ? times[low]! : null;
}

/** The nearest time before `t`. */
export function previousTime(times: ArrayLike<number>, t: number): number | null {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >>> 1;
    if (times[middle]! >= t - SAME_S) high = middle;
    else low = middle + 1;
  }
  return low > 0 ? times[low - 1]! : null;
}
