// The parsed form of a query, with the same structure as in clients/browse/query.h.

/** Limits of a query: length of the text and depth of nesting. */
export const QUERY_BYTES_MAX = 20_000;
export const QUERY_DEPTH_MAX = 100;

/** Bodies of a scene, ascending. One of them must meet the condition, or each. */
export interface Bodies {
  readonly bodies: readonly number[];
  readonly isEvery: boolean;
  /** For each feature of the scene: 1 if it is one of these bodies. */
  readonly isAmong: Uint8Array;
}

/** Low x, y, z, then high x, y, z, in metres; includes the faces. */
export type Box = Float64Array;

export function allOfSpace(): Box {
  return Float64Array.of(-Infinity, -Infinity, -Infinity, Infinity, Infinity, Infinity);
}

/** A time range; includes its ends. */
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
  /** A feature; null: any. */
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
  /** Index into the search index's numbers. */
  readonly number: number;
  readonly low: number;
  readonly high: number;
  readonly isLowOpen: boolean;
  readonly isHighOpen: boolean;
}

/** A condition that holds at a moment. */
export type Moment = Inside | Touches;

export type Condition =
  | Moment
  | EndsIn
  | NumberIn
  /** The steps hold one after another. */
  | { readonly is: "order"; readonly steps: readonly Moment[] }
  | { readonly is: "all" | "any"; readonly parts: readonly Condition[] }
  | { readonly is: "not"; readonly part: Condition };

/** An error in a query, with its position. Texts are bytes (bytes.ts). */
export class QueryFault extends Error {
  override readonly name = "QueryFault";
  constructor(
    /** Index of the first wrong byte, from 0. */
    readonly column: number,
    message: string,
  ) {
    super(message);
  }
}
