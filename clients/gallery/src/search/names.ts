// Names of bodies, features and numbers in queries, and the errors for unknown names.

import { bytesOf } from "./bytes";
import { type Bodies, QueryFault } from "./condition";
import { type Cursor, isKeyword, isUnit } from "./cursor";
import { nearest } from "./nearest";

/** Names that queries can use; bodies come first. */
export interface NamedThings {
  readonly features: readonly { readonly name: string; readonly kind: "body" | "fixed" | "wanted" }[];
  readonly numbers: readonly { readonly name: string; readonly unit: string }[];
}

/** Maximum number of names in a message. */
const SHOWN = 12;
const DIGITS = /^[0-9]*$/;
/** The page's words for numbers, and the numbers' names in queries. */
const OTHER_WORDS: ReadonlyMap<string, string> =
  new Map([["score", "log_constraint"], ["plausibility", "log_prior"]]);

export class Names {
  private readonly features: readonly string[];
  private readonly isGoal: readonly boolean[];
  private readonly bodies: number;
  private readonly numbers: readonly string[];

  constructor(things: NamedThings) {
    this.features = things.features.map((feature) => bytesOf(feature.name));
    this.isGoal = things.features.map((feature) => feature.kind === "wanted");
    this.numbers = things.numbers.map((number) => bytesOf(number.name));
    const end = things.features.findIndex((feature) => feature.kind !== "body");
    this.bodies = end < 0 ? things.features.length : end;
  }

  /** Consumes a name: words with an optional plain number, or a quoted name. */
  taken(cursor: Cursor): string {
    if (cursor.next().kind === "quoted") return cursor.take().text;
    if (!cursor.isFreeWord()) cursor.fail("expected a body, 'any', 'every' or the name of a number");
    let name = cursor.take().text;
    for (;;) {
      const after = cursor.afterNext();
      // In "die 3 in", 3 belongs to the name; in "bounces 3..5" it doesn't.
      const isItsNumber = cursor.next().kind === "number" && DIGITS.test(cursor.next().text) &&
        !(after.kind === "sign" && after.text === "..") &&
        !(after.kind === "word" && (after.isJoined || isUnit(after.text)));
      if (!cursor.isFreeWord() && !isItsNumber) return name;
      name += ` ${cursor.take().text}`;
    }
  }

  /** Consumes "any" or "every", and an optional kind of body. */
  bodiesOfKind(cursor: Cursor): Bodies {
    const isEvery = cursor.take().text === "every";
    const token = cursor.next();
    const hasKind = (token.kind === "word" && !isKeyword(token.text)) || token.kind === "quoted";
    const kind = hasKind ? cursor.take().text : "";
    const bodies: number[] = [];
    for (let body = 0; body < this.bodies; ++body) {
      const name = this.features[body]!;
      // "die" matches "die 1", "die 2", ...
      const isOfKind = kind === "" || name === kind ||
        (name.startsWith(`${kind} `) && DIGITS.test(name.slice(kind.length + 1)));
      if (isOfKind) bodies.push(body);
    }
    // "any body" means "any", unless bodies have that name.
    if (bodies.length === 0 && kind === "body")
      for (let body = 0; body < this.bodies; ++body) bodies.push(body);
    if (bodies.length === 0)
      throw new QueryFault(token.column, kind === "" ? "the scene has no bodies"
        : `no body is named '${kind} N'; the bodies are ${this.shown(this.bodies)}`);
    return this.bodiesOf(bodies, isEvery);
  }

  private bodiesOf(bodies: readonly number[], isEvery: boolean): Bodies {
    const isAmong = new Uint8Array(this.features.length);
    for (const body of bodies) isAmong[body] = 1;
    return { bodies, isEvery, isAmong };
  }

  /** Consumes the partner of a contact; null: any. */
  partner(cursor: Cursor): number | null {
    if (cursor.takeWord("any")) return null;
    const column = cursor.next().column;
    const name = this.taken(cursor);
    const feature = this.features.indexOf(name);
    if (feature < 0) this.failUnknown(name, this.features.length, column);
    if (this.isGoal[feature])
      throw new QueryFault(column,
        `'${name}' is a goal, which bodies cannot touch; use 'in' with the place of the goal`);
    return feature;
  }

  bodyCalled(name: string, column: number): Bodies {
    const feature = this.features.indexOf(name);
    if (feature >= 0 && feature < this.bodies) return this.bodiesOf([feature], false);
    if (feature >= 0)
      throw new QueryFault(column, `'${name}' doesn't move; use 'touches', as in 'any touches ${name}'`);
    if (this.numbers.includes(name))
      throw new QueryFault(column, `'${name}' is a number; expected a range or a comparison after it, ` +
        `as in '${name} 0..1'`);
    this.failUnknown(name, this.bodies, column);
  }

  numberCalled(name: string, column: number): number {
    const number = this.numbers.indexOf(name);
    if (number >= 0) return number;
    const elements = this.numbers.filter((other) => other.startsWith(`${name}[`));
    if (elements.length > 0)
      throw new QueryFault(column,
        `'${name}' has ${elements.length} elements; choose one, such as ${elements[0]!}`);
    if (this.features.includes(name))
      throw new QueryFault(column,
        `'${name}' is not a number; expected 'in', 'touches' or 'ends in' after it`);
    const meant = OTHER_WORDS.get(name);
    const near = meant !== undefined && this.numbers.includes(meant) ? meant : nearest(name, this.numbers);
    throw new QueryFault(column, near === null
      ? `no number is named '${name}'; to list the numbers, run \`sleight find --names\``
      : `no number is named '${name}'; did you mean '${near}'?`);
  }

  private failUnknown(name: string, features: number, column: number): never {
    const near = nearest(name, this.features.slice(0, features));
    throw new QueryFault(column, near === null
      ? `nothing is named '${name}'; the names are ${this.shown(features)}`
      : `nothing is named '${name}'; did you mean '${near}'?`);
  }

  private shown(count: number): string {
    const names = this.features.slice(0, Math.min(count, SHOWN)).join(", ");
    return count > SHOWN ? `${names} and ${count - SHOWN} more` : names;
  }
}
