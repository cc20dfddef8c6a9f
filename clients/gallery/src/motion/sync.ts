// Several animations in step: which moment of each is shown at a shared time.
//
// An animation's own time = shared time + its shift.

import { firstContactS } from "./events";
import type { Recording } from "./recording";

/** What happens in all of them at shared time 0: they begin, something is first hit, all rests. */
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

/** The shared times between which anything happens in any of them. */
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
