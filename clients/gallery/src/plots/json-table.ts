// Shows JSON as tables: lists of objects become rows, other values become named rows.
import { isObject } from "../data/packed";
import { el } from "../ui/dom";
import { number } from "../ui/words";

const rowsMax = 1000;
const depthMax = 6;
/** Longer texts get their own line. */
const shortMax = 24;

export function jsonTable(value: unknown, depth = 0): HTMLElement {
  if (depth > depthMax) return el("span", {}, "…");
  if (Array.isArray(value)) return listTable(value, depth);
  if (isObject(value)) {
    const rows = Object.entries(value)
      .slice(0, rowsMax)
      .map(([name, part]) =>
        el(
          "tr",
          {},
          el("th", { scope: "row" }, name.replaceAll("_", " ")),
          el("td", {}, jsonTable(part, depth + 1)),
        ),
      );
    return el("table", {}, el("tbody", {}, ...rows));
  }
  return el("span", {}, wordsOf(value));
}

function listTable(list: readonly unknown[], depth: number): HTMLElement {
  const rows = list.slice(0, rowsMax);
  if (rows.length === 0) return el("span", {}, "none");
  if (!rows.every(isObject)) {
    const isPlain = rows.every((part) => !isObject(part) && !Array.isArray(part));
    const isShort = rows.every((part) => wordsOf(part).length <= shortMax);
    if (isPlain && isShort) return el("span", {}, rows.map(wordsOf).join(", "));
    return el("ul", {}, ...rows.map((part) => el("li", {}, jsonTable(part, depth + 1))));
  }
  const names = [...new Set(rows.flatMap((row) => Object.keys(row)))];
  return el(
    "table",
    {},
    el(
      "thead",
      {},
      el("tr", {}, ...names.map((name) => el("th", { scope: "col" }, name.replaceAll("_", " ")))),
    ),
    el(
      "tbody",
      {},
      ...rows.map((row) =>
        el("tr", {}, ...names.map((name) => el("td", {}, jsonTable(row[name], depth + 1)))),
      ),
    ),
  );
}

function wordsOf(value: unknown): string {
  if (value === null || value === undefined) return "—";
  if (typeof value === "number") return number(value);
  if (typeof value === "boolean") return value ? "yes" : "no";
  return typeof value === "string" ? value : JSON.stringify(value);
}
