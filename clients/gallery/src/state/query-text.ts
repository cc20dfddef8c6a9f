// Words and numbers as the query language writes them, and queries joined of others.

const keywords = new Set([
  "and",
  "or",
  "not",
  "in",
  "touches",
  "ends",
  "then",
  "during",
  "any",
  "every",
  "x",
  "y",
  "z",
]);

/** Words, and a plain number behind them: what stands in a query without quotes. */
const bare = /^[A-Za-z_][A-Za-z0-9_]*(?: [A-Za-z_][A-Za-z0-9_]*)*(?: [0-9]+)?$/;

export function isBareName(name: string): boolean {
  return bare.test(name) && name.split(" ").every((word) => !keywords.has(word));
}

/** The name as the language takes it: in double quotes where it must be, or `always`. */
export function quotedName(name: string, always = false): string {
  if (!always && isBareName(name)) return name;
  return `"${name.replace(/[\\"]/g, (sign) => `\\${sign}`)}"`;
}

/** Few digits that still say where it is: twelve that count, no trailing zeros. */
export function shortNumber(value: number): string {
  const text = String(Number(value.toPrecision(12)));
  return text === "-0" ? "0" : text;
}

export interface SignedQuery {
  readonly text: string;
  readonly isNot: boolean;
}

/** All of them at once, as one text; "" of none. */
export function joined(queries: readonly SignedQuery[]): string {
  const only = queries.length === 1 ? queries[0] : undefined;
  if (only !== undefined && !only.isNot) return only.text;
  return queries.map(({ text, isNot }) => (isNot ? `not (${text})` : `(${text})`)).join(" and ");
}

/** The place in `text` of its character number `column`, from 1: some characters are two units long. */
export function placeOfColumn(text: string, column: number): number {
  let place = 0;
  let at = 1;
  for (const sign of text) {
    if (at >= column) break;
    at += 1;
    place += sign.length;
  }
  return place;
}
