// Small recordings for tests.
import { Recording } from "../src/motion/recording";
import { type Cause, CAUSES, type Mode, MODES, type Segments } from "../src/motion/segments";

type Triple = readonly [number, number, number];

export interface Row {
  readonly body?: number;
  readonly start?: number;
  readonly mode?: Mode;
  readonly cause?: Cause;
  readonly partner?: number;
  readonly p?: Triple;
  readonly v?: Triple;
  readonly a?: Triple;
  readonly q?: readonly [number, number, number, number];
  readonly w?: Triple;
  readonly wa?: Triple;
}

export function segmentsFrom(rows: readonly Row[]): Segments {
  const flat = (of: (row: Row) => readonly number[]): Float64Array => Float64Array.from(rows.flatMap(of));
  const none: Triple = [0, 0, 0];
  return {
    count: rows.length,
    body: Uint32Array.from(rows, (row) => row.body ?? 0),
    startS: Float64Array.from(rows, (row) => row.start ?? 0),
    mode: Uint8Array.from(rows, (row) => MODES.indexOf(row.mode ?? "flying")),
    cause: Uint8Array.from(rows, (row) => CAUSES.indexOf(row.cause ?? "start")),
    partner: Int32Array.from(rows, (row) => row.partner ?? -1),
    position: flat((row) => row.p ?? none),
    velocity: flat((row) => row.v ?? none),
    acceleration: flat((row) => row.a ?? none),
    orientation: flat((row) => row.q ?? [1, 0, 0, 0]),
    angularVelocity: flat((row) => row.w ?? none),
    angularAcceleration: flat((row) => row.wa ?? none),
  };
}

export function recordingFrom(rows: readonly Row[], bodies = 1): Recording {
  return new Recording(segmentsFrom(rows), bodies);
}
