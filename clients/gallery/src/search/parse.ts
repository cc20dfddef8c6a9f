// The parser of queries. The rules and errors equal those of clients/browse/parse.cpp. After each rule, the
// cursor is at the next token.

import { bytesOf, characterAt, textOf } from "./bytes";
import {
  allOfSpace, type Bodies, type Box, type Condition, type Moment, type NumberIn, QUERY_DEPTH_MAX,
  QueryFault,
} from "./condition";
import { Cursor, dimensionOf } from "./cursor";
import { type NamedThings, Names } from "./names";
import { tokensOf } from "./tokens";

export interface QueryError {
  /** Position of the error in characters, from 1. */
  readonly column: number;
  readonly message: string;
}

const THEN_JOINS = "'then' can only join '... in BOX' and '... touches ...'";
const AXES: readonly string[] = ["x", "y", "z"];
const COMPARISONS: readonly string[] = ["<", "<=", ">", ">=", "="];

/** Parses a text for an index with these names. */
export function parseQuery(text: string, things: NamedThings): Condition | QueryError {
  const bytes = bytesOf(text);
  try {
    return parseBytes(bytes, things);
  } catch (error) {
    if (!(error instanceof QueryFault)) throw error;
    return { column: characterAt(bytes, error.column), message: textOf(error.message) };
  }
}

/** Throws QueryFault. */
export function parseBytes(bytes: string, things: NamedThings): Condition {
  return new Parser(new Cursor(tokensOf(bytes)), things).whole();
}

class Parser {
  private depth = 0;
  private readonly names: Names;

  constructor(private readonly cursor: Cursor, private readonly things: NamedThings) {
    this.names = new Names(things);
  }

  whole(): Condition {
    if (this.cursor.next().kind === "end") this.cursor.fail("expected a query, such as 'any in x 0..20mm'");
    const condition = this.anyOf();
    if (this.cursor.next().kind !== "end") this.cursor.fail("expected 'and', 'or', 'then' or the end of the query");
    return condition;
  }

  // ---- and, or, not, then

  private anyOf(): Condition {
    const parts: Condition[] = [];
    do parts.push(this.allOf());
    while (this.cursor.takeWord("or"));
    return parts.length === 1 ? parts[0]! : { is: "any", parts };
  }

  private allOf(): Condition {
    const parts: Condition[] = [];
    do parts.push(this.negated());
    while (this.cursor.takeWord("and"));
    return parts.length === 1 ? parts[0]! : { is: "all", parts };
  }

  private negated(): Condition {
    if (++this.depth > QUERY_DEPTH_MAX)
      this.cursor.fail(`the query is nested more than ${QUERY_DEPTH_MAX} levels deep`);
    let condition: Condition;
    if (this.cursor.takeWord("not")) {
      condition = { is: "not", part: this.negated() };
    } else if (this.cursor.takeSign("(")) {
      condition = this.anyOf();
      if (!this.cursor.takeSign(")")) this.cursor.fail("expected ')'");
    } else {
      condition = this.inOrder();
    }
    --this.depth;
    return condition;
  }

  private inOrder(): Condition {
    const column = this.cursor.next().column;
    const first = this.term();
    if (!this.cursor.isWord("then")) return first;
    const steps: Moment[] = [momentOf(first, column)];
    while (this.cursor.takeWord("then")) {
      const begin = this.cursor.next().column;
      if (this.cursor.isWord("not") || this.cursor.isSign("(")) this.cursor.fail(THEN_JOINS);
      steps.push(momentOf(this.term(), begin));
    }
    return { is: "order", steps };
  }

  // ---- Terms

  private term(): Condition {
    const { cursor } = this;
    const column = cursor.next().column;
    if (cursor.isWord("any") || cursor.isWord("every")) return this.ofBodies(this.names.bodiesOfKind(cursor));
    const name = this.names.taken(cursor);
    const { kind, text } = cursor.next();
    const isOfNumber = kind === "number" || (kind === "sign" && text !== ":" && text !== ")" && text !== ",");
    if (isOfNumber) return this.ofNumber(name, column);
    return this.ofBodies(this.names.bodyCalled(name, column));
  }

  private ofBodies(who: Bodies): Condition {
    const cursor: Cursor = this.cursor;
    if (cursor.takeWord("in") || cursor.takeSign(":")) {
      const box = this.box();
      return { is: "inside", who, box, when: cursor.during() };
    }
    if (cursor.takeWord("touches")) {
      const partner = this.names.partner(cursor);
      return { is: "touches", who, partner, when: cursor.during() };
    }
    if (cursor.takeWord("ends")) {
      if (!cursor.takeWord("in")) cursor.fail("expected 'in', as in '... ends in x 0..20mm'");
      return { is: "ends", who, box: this.box() };
    }
    cursor.fail("expected 'in', 'touches' or 'ends in'");
  }

  private ofNumber(begun: string, column: number): NumberIn {
    const { cursor } = this;
    let name = begun;
    while (cursor.takeSign("[")) {
      name += "[";
      while (!cursor.takeSign("]")) {
        if (cursor.next().kind !== "number" && !cursor.isSign(",")) cursor.fail("expected ']'");
        name += cursor.take().text;
      }
      name += "]";
    }
    const number = this.names.numberCalled(name, column);
    const dimension = dimensionOf(this.things.numbers[number]!.unit);
    const comparison = COMPARISONS.find((sign) => cursor.isSign(sign));
    if (comparison === undefined)
      return { is: "number", number, ...cursor.range(dimension), isLowOpen: false, isHighOpen: false };
    cursor.take();
    if (cursor.next().kind !== "number") cursor.fail("expected a number");
    const plain = cursor.take().number;
    const value = plain * (cursor.takenUnit(dimension) ?? 1);
    return {
      is: "number",
      number,
      low: comparison.startsWith("<") ? -Infinity : value,
      high: comparison.startsWith(">") ? Infinity : value,
      isLowOpen: comparison === ">",
      isHighOpen: comparison === "<",
    };
  }

  private box(): Box {
    const { cursor } = this;
    const box = allOfSpace();
    const seen = [false, false, false];
    for (;;) {
      const axis = AXES.findIndex((word) => cursor.isWord(word));
      if (axis < 0) break;
      if (seen[axis]) cursor.fail(`${AXES[axis]!} already has a range`);
      seen[axis] = true;
      cursor.take();
      const ends = cursor.range("a length");
      box[axis] = ends.low;
      box[axis + 3] = ends.high;
      const isAxisBehind = cursor.afterNext().kind === "word" && AXES.includes(cursor.afterNext().text);
      if (cursor.isSign(",") && isAxisBehind) cursor.take();
    }
    if (!seen.includes(true)) cursor.fail("expected a range of x, y or z, such as 'x 0..20mm'");
    return box;
  }
}

function momentOf(condition: Condition, column: number): Moment {
  if (condition.is === "inside" || condition.is === "touches") return condition;
  throw new QueryFault(column, THEN_JOINS);
}
