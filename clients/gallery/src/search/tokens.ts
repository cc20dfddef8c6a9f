// Tokens of a query's text, with the same errors as clients/browse/tokens.cpp.

import { QUERY_BYTES_MAX, QueryFault } from "./condition";

export interface Token {
  /** word: letters, digits and _, starting with a letter; quoted: a name in double quotes. */
  readonly kind: "word" | "quoted" | "number" | "sign" | "end";
  /** Index of the first byte, from 0. */
  readonly column: number;
  /** For a quoted name, the text between the quotes. */
  readonly text: string;
  /** The value of a number; 0 for other tokens. */
  readonly number: number;
  /** Directly after the previous token, as the unit in "20mm". */
  readonly isJoined: boolean;
}

// Sticky: each expression matches only at its lastIndex.
const BLANKS = /[ \t\n]*/y;
/** A unit such as "mm/s" is one word; only units contain a slash. */
const WORD = /(?:mm?\/[A-Za-z_]+|[A-Za-z_][A-Za-z_0-9]*)/y;
const IS_WORD = /[A-Za-z_]/y;
const IS_NUMBER = /[-+]?(?:[0-9]|\.[0-9])/y;
/** "0..20" is 0, then "..": a point followed by a second point isn't part of the number. */
const NUMBER = /[-+]?[0-9]*(?:\.(?!\.)[0-9]*)?(?:[eE][-+]?[0-9]+)?/y;
const SIGN = /\.\.|<=|>=|[<>=():,[\]]/y;

/** The tokens, ending with one of kind "end". Throws QueryFault. */
export function tokensOf(bytes: string): Token[] {
  if (bytes.length > QUERY_BYTES_MAX)
    throw new QueryFault(QUERY_BYTES_MAX, `the query is longer than ${QUERY_BYTES_MAX} bytes`);
  const tokens: Token[] = [];
  let at = 0;
  for (;;) {
    const blanks = matched(BLANKS, bytes, at) ?? "";
    const isJoined = blanks === "" && tokens.length > 0;
    at += blanks.length;
    const token = tokenAt(bytes, at, isJoined);
    tokens.push(token.token);
    if (token.token.kind === "end") return tokens;
    at = token.end;
  }
}

function tokenAt(bytes: string, column: number, isJoined: boolean): { token: Token; end: number } {
  if (column === bytes.length)
    return { token: { kind: "end", column, text: "", number: 0, isJoined }, end: column };
  if (matched(IS_WORD, bytes, column) !== null) {
    const text = matched(WORD, bytes, column) ?? "";
    return { token: { kind: "word", column, text, number: 0, isJoined }, end: column + text.length };
  }
  if (bytes[column] === "\"") {
    const { text, end } = quotedAt(bytes, column);
    return { token: { kind: "quoted", column, text, number: 0, isJoined }, end };
  }
  if (matched(IS_NUMBER, bytes, column) !== null) {
    const text = matched(NUMBER, bytes, column) ?? "";
    const number = numberOf(text, column);
    return { token: { kind: "number", column, text, number, isJoined }, end: column + text.length };
  }
  const text = matched(SIGN, bytes, column);
  if (text !== null)
    return { token: { kind: "sign", column, text, number: 0, isJoined }, end: column + text.length };
  const sign = bytes[column] ?? "";
  throw new QueryFault(column, sign > " " && sign < "\x7f"
    ? `unexpected character '${sign}'` : "unexpected character");
}

/** \" and \\ stand for the characters " and \. */
function quotedAt(bytes: string, column: number): { text: string; end: number } {
  let text = "";
  for (let at = column + 1; at < bytes.length; ++at) {
    if (bytes[at] === "\"") return { text, end: at + 1 };
    if (bytes[at] === "\\" && at + 1 < bytes.length) ++at;
    text += bytes[at] ?? "";
  }
  throw new QueryFault(column, "the closing quote is missing");
}

function numberOf(text: string, column: number): number {
  const number = Number(text);
  // The number is too large for a double, or so small that it becomes 0.
  const isLost = number === 0 && /[1-9]/.test(text.replace(/[eE].*/, ""));
  if (!Number.isFinite(number) || isLost)
    throw new QueryFault(column, `the number '${text}' is too large or too small`);
  return number;
}

function matched(pattern: RegExp, bytes: string, at: number): string | null {
  pattern.lastIndex = at;
  return pattern.exec(bytes)?.[0] ?? null;
}
