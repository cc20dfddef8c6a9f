// Conditions that the builder can express, and their text in the query language (docs/BROWSING.md). This
// module has lengths in metres and times in seconds; the text has millimetres, which people prefer.
import { isBareName, quotedName, shortNumber } from "./query-text";

/** null: no limit on this side. */
export interface Range {
  readonly low: number | null;
  readonly high: number | null;
}

export interface Box {
  readonly x: Range;
  readonly y: Range;
  readonly z: Range;
}

export type Who =
  | { readonly kind: "body"; readonly name: string }
  /** All bodies (`of` is ""), or the bodies named `of` and a number. */
  | { readonly kind: "any" | "every"; readonly of: string };

export interface InsideStep {
  readonly kind: "in";
  readonly who: Who;
  readonly box: Box;
  readonly during: Range;
}

export interface TouchStep {
  readonly kind: "touches";
  readonly who: Who;
  /** A feature's name; "" means any feature. */
  readonly partner: string;
  readonly during: Range;
}

export type Step = InsideStep | TouchStep;

export type Condition =
  /** One step, or several steps in the order of time. */
  | { readonly kind: "steps"; readonly steps: readonly Step[] }
  | { readonly kind: "ends"; readonly who: Who; readonly box: Box }
  | { readonly kind: "number"; readonly name: string; readonly range: Range };

export const openRange: Range = { low: null, high: null };

export function isOpen(range: Range): boolean {
  return range.low === null && range.high === null;
}

/** Kinds for queries such as `any die`: words before a number in several bodies' names. */
export function kindsOfBodies(names: readonly string[]): string[] {
  const counts = new Map<string, number>();
  for (const name of names) {
    const kind = /^(.+) \d+$/.exec(name)?.[1];
    if (kind !== undefined) counts.set(kind, (counts.get(kind) ?? 0) + 1);
  }
  return [...counts].filter(([, count]) => count > 1).map(([kind]) => kind);
}

/** What the condition still lacks, as a message; "" if it is complete. */
export function missingIn(condition: Condition): string {
  if (condition.kind === "number") {
    if (condition.name === "") return "Select a number.";
    return missingInRange(condition.range) || (isOpen(condition.range) ? "Enter a lower or an upper limit." : "");
  }
  if (condition.kind === "ends") return missingInBox(condition.box);
  if (condition.steps.length === 0) return "Add a step.";
  for (const step of condition.steps) {
    const words = (step.kind === "in" ? missingInBox(step.box) : "") || missingInRange(step.during);
    if (words !== "") return words;
  }
  return "";
}

function missingInRange(range: Range): string {
  if (range.low !== null && range.high !== null && range.low > range.high)
    return "The lower limit is above the upper limit.";
  return "";
}

function missingInBox(box: Box): string {
  const ranges = [box.x, box.y, box.z];
  if (ranges.every(isOpen)) return "Draw a box, or enter a range of x, y or z.";
  return ranges.map(missingInRange).find((words) => words !== "") ?? "";
}

/** REQUIRES: missingIn(condition) is "". */
export function queryOf(condition: Condition): string {
  switch (condition.kind) {
    case "number":
      return `${numberName(condition.name)} ${rangeText(condition.range, 1, "")}`;
    case "ends":
      return `${whoText(condition.who)} ends in ${boxText(condition.box)}`;
    case "steps":
      return condition.steps.map(stepText).join(" then ");
  }
}

function stepText(step: Step): string {
  const during = isOpen(step.during) ? "" : ` during ${rangeText(step.during, 1, "s")}`;
  if (step.kind === "in") return `${whoText(step.who)} in ${boxText(step.box)}${during}`;
  const partner = step.partner === "" ? "any" : quotedName(step.partner);
  return `${whoText(step.who)} touches ${partner}${during}`;
}

function whoText(who: Who): string {
  if (who.kind === "body") return quotedName(who.name);
  if (who.of === "") return who.kind;
  // A kind is a single token.
  const isOneWord = isBareName(who.of) && !who.of.includes(" ");
  return `${who.kind} ${isOneWord ? who.of : quotedName(who.of, true)}`;
}

function boxText(box: Box): string {
  return (["x", "y", "z"] as const)
    .filter((axis) => !isOpen(box[axis]))
    .map((axis) => `${axis} ${rangeText(box[axis], 1000, "mm")}`)
    .join(" ");
}

/** "0..20mm", "..20mm" or "0mm..": a unit after the range applies to both ends. */
export function rangeText(range: Range, scale: number, unit: string): string {
  const low = range.low === null ? "" : shortNumber(range.low * scale);
  const high = range.high === null ? "" : shortNumber(range.high * scale);
  return high === "" ? `${low}${unit}..` : `${low}..${high}${unit}`;
}

/** A number's name. Its subscripts follow in brackets, outside of quotes. */
function numberName(name: string): string {
  const parts = /^(.*?)((?:\[[-+0-9.,]*\])*)$/.exec(name);
  const base = parts?.[1] ?? name;
  // The name is quoted, because the range's first number after "ball 3" would be ambiguous.
  return `${quotedName(base, / \d+$/.test(base))}${parts?.[2] ?? ""}`;
}
