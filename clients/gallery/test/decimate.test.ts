// Goal: thinned lines show all extremes of the original line in each column of pixels. Method: thin a line
// with spikes and gaps, compare with a slow method, and align several lines.
import assert from "node:assert/strict";
import { test } from "node:test";
import { aligned } from "../src/plots/aligned";
import { decimated, lowerBound } from "../src/plots/decimate";

function line(count: number): { x: Float64Array; y: Float64Array } {
  const x = Float64Array.from({ length: count }, (_, i) => i);
  const y = x.map((i) => Math.sin(i / 500) + ((i * 7919) % 1009 === 0 ? 5 : 0));
  return { x, y };
}

test("each column of pixels keeps its lowest and highest values", () => {
  const whole = line(100_000);
  whole.y.fill(NaN, 5000, 6000);
  const columns = 300;
  const [from, to] = [1000, 91_000];
  const thin = decimated(whole, from, to, columns);
  assert.ok(thin.x.length <= 4 * (columns + 3));
  const column = (x: number): number => Math.floor(((x - from) * columns) / (to - from));
  const extremes = (x: Float64Array, y: Float64Array): Map<number, [number, number]> => {
    const found = new Map<number, [number, number]>();
    x.forEach((value, i) => {
      const height = y[i] ?? NaN;
      if (value < from || value >= to || Number.isNaN(height)) return;
      const [low, high] = found.get(column(value)) ?? [Infinity, -Infinity];
      found.set(column(value), [Math.min(low, height), Math.max(high, height)]);
    });
    return found;
  };
  assert.deepEqual([...extremes(thin.x, thin.y)], [...extremes(whole.x, whole.y)]);
  for (let i = 1; i < thin.x.length; i++) assert.ok((thin.x[i] ?? 0) > (thin.x[i - 1] ?? 0));
});

test("if a range has few points, all are kept, and one more on each side", () => {
  const { x } = decimated(line(1000), 100, 110, 500);
  assert.deepEqual([x[0], x[x.length - 1]], [99, 111]);
  assert.equal(decimated({ x: [], y: [] }, 0, 1, 10).x.length, 0);
  assert.equal(lowerBound([1, 2, 2, 3], 2), 1);
});

test("in lines merged over one axis, undefined means no point and null means a gap", () => {
  const a = { x: Float64Array.of(0, 2), y: Float64Array.of(1, NaN) };
  const b = { x: Float64Array.of(1, 2), y: Float64Array.of(5, 6) };
  assert.deepEqual(aligned([a, b]), [
    [0, 1, 2],
    [1, undefined, null],
    [undefined, 5, 6],
  ]);
});
