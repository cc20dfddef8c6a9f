// Formats names and numbers for the query language, and joins queries.
import { isKeyword } from "../search/cursor";

/** Names without quotes: words, optionally followed by an integer. */
const bare = /^[A-Za-z_][A-Za-z0-9_]*(?: [A-Za-z_][A-Za-z0-9_]*)*(?: [0-9]+)?$/;

export function isBareName(name: string): boolean {
  return bare.test(name) && name.split(" ").every((word) => !isKeyword(word));
}

/** The name for a query: in double quotes if necessary, or if `always`. */
export function quotedName(name: string, always = false): string {
  if (!always && isBareName(name)) return name;
  return `"${name.replace(/[\\"]/g, (sign) => `\\${sign}`)}"`;
}

/** At most twelve significant digits, without trailing zeros. */
export function shortNumber(value: number): string {
  const text = String(Number(value.toPrecision(12)));
  return text === "-0" ? "0" : text;
}

export interface SignedQuery {
  readonly text: string;
  readonly isNot: boolean;
}

/** All queries combined with "and"; "" if there are none. */
export function joined(queries: readonly SignedQuery[]): string {
  const only = queries.length === 1 ? queries[0] : undefined;
  if (only !== undefined && !only.isNot) return only.text;
  return queries.map(({ text, isNot }) => (isNot ? `not (${text})` : `(${text})`)).join(" and ");
}

/** Converts a column (characters from 1) to an index in `text`: some characters take two UTF-16 units. */
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
