// What a query means: the forms that clients/browse/query.h has.

/** Longest text, and deepest nesting of a query. */
export const QUERY_BYTES_MAX = 20_000;
export const QUERY_DEPTH_MAX = 100;

/** Bodies of a scene, ascending: one of them must do what is asked, or each. */
export interface Bodies {
  readonly bodies: readonly number[];
  readonly isEvery: boolean;
  /** By feature of the scene: 1 of these bodies. */
  readonly isAmong: Uint8Array;
}

/** Low x, y, z, then high x, y, z, in metres; its faces belong to it. */
export type Box = Float64Array;

export function allOfSpace(): Box {
  return Float64Array.of(-Infinity, -Infinity, -Infinity, Infinity, Infinity, Infinity);
}

/** A stretch of time; its ends belong to it. */
export interface Stretch {
  readonly fromS: number;
  readonly toS: number;
}
export const ALL_TIME: Stretch = { fromS: -Infinity, toS: Infinity };

export interface Inside {
  readonly is: "inside";
  readonly who: Bodies;
  readonly box: Box;
  readonly when: Stretch;
}

export interface Touches {
  readonly is: "touches";
  readonly who: Bodies;
  /** A feature; null: whatever it is. */
  readonly partner: number | null;
  readonly when: Stretch;
}

export interface EndsIn {
  readonly is: "ends";
  readonly who: Bodies;
  readonly box: Box;
}

export interface NumberIn {
  readonly is: "number";
  /** Along the index's numbers. */
  readonly number: number;
  readonly low: number;
  readonly high: number;
  readonly isLowOpen: boolean;
  readonly isHighOpen: boolean;
}

/** What happens at a moment. */
export type Moment = Inside | Touches;

export type Condition =
  | Moment
  | EndsIn
  | NumberIn
  /** One after another. */
  | { readonly is: "order"; readonly steps: readonly Moment[] }
  | { readonly is: "all" | "any"; readonly parts: readonly Condition[] }
  | { readonly is: "not"; readonly part: Condition };

/** What is wrong with a query's text, and where; texts are bytes (bytes.ts). */
export class QueryFault extends Error {
  override readonly name = "QueryFault";
  constructor(
    /** Of the first byte that is wrong, from 0. */
    readonly column: number,
    message: string,
  ) {
    super(message);
  }
}
