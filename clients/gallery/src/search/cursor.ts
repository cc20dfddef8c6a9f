// The parser's position among a query's tokens, and parsing of ranges and units.

import { QueryFault, type Stretch, ALL_TIME } from "./condition";
import type { Token } from "./tokens";

export type Dimension = "a pure number" | "a length" | "a time" | "an angle" | "a speed";

interface Unit {
  readonly name: string;
  readonly dimension: Dimension;
  /** Size of one unit in SI. */
  readonly si: number;
}

const UNITS: readonly Unit[] = [
  { name: "um", dimension: "a length", si: 1e-6 },
  { name: "mm", dimension: "a length", si: 1e-3 },
  { name: "cm", dimension: "a length", si: 1e-2 },
  { name: "m", dimension: "a length", si: 1 },
  { name: "us", dimension: "a time", si: 1e-6 },
  { name: "ms", dimension: "a time", si: 1e-3 },
  { name: "s", dimension: "a time", si: 1 },
  { name: "deg", dimension: "an angle", si: Math.PI / 180 },
  { name: "rad", dimension: "an angle", si: 1 },
  { name: "mm/s", dimension: "a speed", si: 1e-3 },
  { name: "m/s", dimension: "a speed", si: 1 },
];

const KEYWORDS: ReadonlySet<string> = new Set([
  "and", "or", "not", "in", "touches", "ends", "then", "during", "any", "every", "x", "y", "z"]);

/** The dimension of a number's unit, as archives write it. */
export function dimensionOf(unit: string): Dimension {
  switch (unit) {
    case "m": return "a length";
    case "s": return "a time";
    case "rad": return "an angle";
    case "m s-1": return "a speed";
    default: return "a pure number";
  }
}

export function isUnit(word: string): boolean {
  return UNITS.some((unit) => unit.name === word);
}

export function isKeyword(word: string): boolean {
  return KEYWORDS.has(word);
}

/** Limits of a range, in SI; a missing limit is infinite. */
export interface Ends {
  readonly low: number;
  readonly high: number;
}

export class Cursor {
  private at = 0;

  /** REQUIRES: the last token has kind "end". */
  constructor(private readonly tokens: readonly Token[]) {}

  next(): Token {
    return this.tokens[this.at]!;
  }
  afterNext(): Token {
    return this.tokens[Math.min(this.at + 1, this.tokens.length - 1)]!;
  }
  /** REQUIRES: the next token isn't the end. */
  take(): Token {
    return this.tokens[this.at++]!;
  }

  fail(message: string): never {
    throw new QueryFault(this.next().column, message);
  }

  isWord(word: string): boolean {
    return this.next().kind === "word" && this.next().text === word;
  }
  isSign(sign: string): boolean {
    return this.next().kind === "sign" && this.next().text === sign;
  }
  /** Whether the next token is a word but no keyword. */
  isFreeWord(): boolean {
    return this.next().kind === "word" && !isKeyword(this.next().text);
  }
  takeWord(word: string): boolean {
    const isIt = this.isWord(word);
    if (isIt) ++this.at;
    return isIt;
  }
  takeSign(sign: string): boolean {
    const isIt = this.isSign(sign);
    if (isIt) ++this.at;
    return isIt;
  }

  range(dimension: Dimension): Ends {
    const column = this.next().column;
    let low: number | null = null;
    let high: number | null = null;
    let lowUnit: number | null = null;
    let highUnit: number | null = null;
    if (this.next().kind === "number") {
      low = this.take().number;
      lowUnit = this.takenUnit(dimension);
    }
    if (!this.takeSign("..")) this.fail("expected '..', as in 0..20, 0.. or ..20");
    if (this.next().kind === "number") {
      high = this.take().number;
      highUnit = this.takenUnit(dimension);
    }
    if (low === null && high === null)
      throw new QueryFault(column, "a range needs at least one end, as in 0.. or ..20");
    // If only one limit of a range has a unit, the unit applies to both limits.
    const ends = {
      low: low === null ? -Infinity : low * (lowUnit ?? highUnit ?? 1),
      high: high === null ? Infinity : high * (highUnit ?? lowUnit ?? 1),
    };
    if (ends.low > ends.high)
      throw new QueryFault(column, "the range is empty, because its first value is above its second value");
    return ends;
  }

  /** Consumes a unit and returns its size in SI; null if there is no unit. */
  takenUnit(dimension: Dimension): number | null {
    const token = this.next();
    if (token.kind !== "word") return null;
    const unit = UNITS.find((one) => one.name === token.text);
    if (unit === undefined) {
      // A word after a blank is not a unit.
      if (!token.isJoined) return null;
      this.fail(`'${token.text}' is not a unit; the units are ${UNITS.map((one) => one.name).join(", ")}`);
    }
    if (unit.dimension !== dimension)
      this.fail(`expected ${dimension} here, but ${unit.name} is a unit of ${unit.dimension}`);
    ++this.at;
    return unit.si;
  }

  during(): Stretch {
    if (!this.takeWord("during")) return ALL_TIME;
    const ends = this.range("a time");
    return { fromS: ends.low, toS: ends.high };
  }
}
