// The order of the list.
import { nameToday } from "../data/types";

export type SortKey =
  /** The archive's order. */
  | { readonly by: "kept" }
  | { readonly by: "number"; readonly number: string; readonly isDescending: boolean }
  /** Nearest to these animations first, or furthest first if isUnlike. */
  | { readonly by: "alike"; readonly to: readonly string[]; readonly isUnlike: boolean };

export const asKept: SortKey = { by: "kept" };

/** Sorts entries by a column. The sort is stable; entries without a number are last in either direction. */
export function sortedByNumber(
  entries: Uint32Array,
  column: ArrayLike<number>,
  isDescending: boolean,
): Uint32Array {
  const sign = isDescending ? -1 : 1;
  const order = Array.from(entries);
  order.sort((a, b) => {
    const left = column[a] ?? NaN;
    const right = column[b] ?? NaN;
    if (Number.isNaN(left) || Number.isNaN(right)) {
      if (Number.isNaN(left) && Number.isNaN(right)) return a - b;
      return Number.isNaN(left) ? 1 : -1;
    }
    return left === right ? a - b : sign * (left - right);
  });
  return Uint32Array.from(order);
}

export function sortToText(sort: SortKey): string {
  if (sort.by === "kept") return "";
  if (sort.by === "alike") return `${sort.isUnlike ? "unlike" : "like"}:${sort.to.join(",")}`;
  return `${sort.isDescending ? "-" : "+"}${sort.number}`;
}

export function sortFromText(text: string): SortKey {
  const alike = /^(un)?like:(.+)$/.exec(text);
  if (alike !== null)
    return { by: "alike", isUnlike: alike[1] !== undefined, to: (alike[2] ?? "").split(",").map(nameToday) };
  if (/^[-+]./.test(text)) return { by: "number", number: text.slice(1), isDescending: text.startsWith("-") };
  return asKept;
}
