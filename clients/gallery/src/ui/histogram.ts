// Histogram of a number over the animations shown. Bars within the range are darker.
import type { Range } from "../state/conditions";
import { svgEl } from "./dom";
import { number } from "./words";

const bars = 40;
const width = 240;
const height = 48;

export interface Spread {
  readonly low: number;
  readonly high: number;
  readonly counts: readonly number[];
}

/** Histogram of these entries' finite values; null if there are none. */
export function spreadOf(column: ArrayLike<number>, entries: Uint32Array): Spread | null {
  let low = Infinity;
  let high = -Infinity;
  for (const entry of entries) {
    const value = column[entry] ?? NaN;
    if (!Number.isFinite(value)) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  if (low > high) return null;
  const counts = new Array<number>(bars).fill(0);
  const scale = high > low ? bars / (high - low) : 0;
  for (const entry of entries) {
    const value = column[entry] ?? NaN;
    if (!Number.isFinite(value)) continue;
    const bar = Math.min(bars - 1, Math.floor((value - low) * scale));
    counts[bar] = (counts[bar] ?? 0) + 1;
  }
  return { low, high, counts };
}

export function histogram(spread: Spread, range: Range, name: string): SVGSVGElement {
  const { low, high, counts } = spread;
  const most = Math.max(...counts);
  const label = `${name}: from ${number(low)} to ${number(high)}`;
  const svg = svgEl("svg", {
    viewBox: `0 0 ${width} ${height}`,
    class: "histogram",
    role: "img",
    "aria-label": label,
  });
  counts.forEach((bar, i) => {
    const from = low + ((high - low) * i) / bars;
    const to = low + ((high - low) * (i + 1)) / bars;
    const isIn = to >= (range.low ?? -Infinity) && from <= (range.high ?? Infinity);
    // Rare values stay visible: each non-empty bar has a minimum height.
    const tall = bar === 0 ? 0 : Math.max(2, (height * bar) / most);
    svg.append(
      svgEl("rect", {
        x: (width * i) / bars,
        y: height - tall,
        width: width / bars - 1,
        height: tall,
        class: isIn ? "bar bar-in" : "bar",
      }),
    );
  });
  return svg;
}
