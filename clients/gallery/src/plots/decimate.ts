// Thins long series to what a screen can show, without losing extremes. Each column of pixels keeps its
// first, lowest, highest and last point, in their order. A million points on 800 columns become at most
// 3,200.

import { firstPast } from "../motion/bisection";

export interface Series {
  /** In ascending order. */
  readonly x: ArrayLike<number>;
  readonly y: ArrayLike<number>;
}

export interface Thinned {
  readonly x: Float64Array;
  readonly y: Float64Array;
}

/** The first index with x >= `value`. */
export function lowerBound(x: ArrayLike<number>, value: number): number {
  return firstPast(x.length, (i) => !(x[i]! < value));
}

/** Thins the part of the series between `from` and `to` to this many columns. One neighbour on each side is
 *  included, so that lines reach the picture's edges. NaN is a gap and is kept. */
export function decimated(series: Series, from: number, to: number, columns: number): Thinned {
  const { x, y } = series;
  const begin = Math.max(0, lowerBound(x, from) - 1);
  const end = Math.min(x.length, lowerBound(x, to) + 2);
  const count = end - begin;
  if (count <= 4 * columns) return copied(series, begin, end);
  const outX = new Float64Array(4 * (columns + 3));
  const outY = new Float64Array(4 * (columns + 3));
  let size = 0;
  const scale = to > from ? columns / (to - from) : 0;
  const columnOf = (value: number): number =>
    Math.min(columns, Math.max(-1, Math.floor((value - from) * scale)));
  const put = (index: number): void => {
    outX[size] = x[index] ?? NaN;
    outY[size] = y[index] ?? NaN;
    size += 1;
  };
  let i = begin;
  while (i < end) {
    const column = columnOf(x[i] ?? NaN);
    const first = i;
    let lowest = i;
    let highest = i;
    let low = y[i] ?? NaN;
    let high = low;
    for (i += 1; i < end && columnOf(x[i] ?? NaN) === column; i++) {
      const value = y[i] ?? NaN;
      // The negated comparisons replace an initial NaN by any number.
      if (!(value >= low) && !Number.isNaN(value)) {
        low = value;
        lowest = i;
      }
      if (!(value <= high) && !Number.isNaN(value)) {
        high = value;
        highest = i;
      }
    }
    const last = i - 1;
    put(first);
    const inner = lowest < highest ? [lowest, highest] : [highest, lowest];
    let before = first;
    for (const index of inner) {
      if (index > before && index < last) {
        put(index);
        before = index;
      }
    }
    if (last > first) put(last);
  }
  return { x: outX.subarray(0, size), y: outY.subarray(0, size) };
}

function copied({ x, y }: Series, begin: number, end: number): Thinned {
  const outX = new Float64Array(end - begin);
  const outY = new Float64Array(end - begin);
  for (let i = begin; i < end; i++) {
    outX[i - begin] = x[i] ?? NaN;
    outY[i - begin] = y[i] ?? NaN;
  }
  return { x: outX, y: outY };
}
