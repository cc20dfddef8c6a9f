// Aligns several animations: maps shared time to each animation's own time.
//
// Own time = shared time + the animation's shift.

import { firstContactS } from "./events";
import type { Recording } from "./recording";

/** What happens at shared time 0: all start, all have their first contact, or all come to rest. */
export type SyncMode = "start" | "contact" | "end";

export function shiftOf(recording: Recording, mode: SyncMode): number {
  switch (mode) {
    case "start": return 0;
    case "contact": return firstContactS(recording);
    case "end": return recording.endS;
  }
}

export interface Range {
  readonly from: number;
  readonly to: number;
}

/** The range of shared time that contains all animations. */
export function sharedRange(recordings: readonly Recording[], mode: SyncMode): Range {
  let from = Infinity;
  let to = -Infinity;
  for (const recording of recordings) {
    const shift = shiftOf(recording, mode);
    from = Math.min(from, Math.min(0, recording.startS) - shift);
    to = Math.max(to, recording.endS - shift);
  }
  return from <= to ? { from, to } : { from: 0, to: 0 };
}
