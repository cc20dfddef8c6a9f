// Two number fields for a range. An empty field means no limit.
import type { Range } from "../state/conditions";
import { shortNumber } from "../state/query-text";
import { el } from "./dom";

export interface RangeFields {
  readonly element: HTMLElement;
  readonly range: Range;
  set(range: Range): void;
}

/** `scale`: displayed units per SI unit (1000 for millimetres). */
export function rangeFields(
  label: string,
  unit: string,
  scale: number,
  onChange: () => void,
): RangeFields {
  const make = (end: string): HTMLInputElement =>
    el("input", {
      type: "number",
      step: "any",
      "aria-label": `${label} ${end}${unit === "" ? "" : ` in ${unit}`}`,
      placeholder: "any",
      on: { input: onChange },
    });
  const low = make("from");
  const high = make("to");
  const valueOf = (input: HTMLInputElement): number | null => {
    const value = input.value.trim() === "" ? NaN : Number(input.value);
    return Number.isFinite(value) ? value / scale : null;
  };
  const put = (input: HTMLInputElement, value: number | null): void => {
    input.value = value === null ? "" : shortNumber(Number((value * scale).toPrecision(10)));
  };
  return {
    element: el(
      "div",
      { class: "range", role: "group", "aria-label": label },
      el("span", { class: "range-label", "aria-hidden": "true" }, label),
      low,
      el("span", { "aria-hidden": "true" }, "to"),
      high,
      el("span", { class: "unit", "aria-hidden": "true" }, unit),
    ),
    get range() {
      return { low: valueOf(low), high: valueOf(high) };
    },
    set(range) {
      put(low, range.low);
      put(high, range.high);
    },
  };
}
