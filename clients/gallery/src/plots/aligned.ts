// Merges several thinned lines onto one x axis, as uPlot requires. In a column, `undefined` means no point at
// this x (the line continues); `null` means a gap.
import type { Thinned } from "./decimate";

export type AlignedColumn = (number | null | undefined)[];

export function aligned(lines: readonly Thinned[]): [number[], ...AlignedColumn[]] {
  const x: number[] = [];
  const columns: AlignedColumn[] = lines.map(() => []);
  const at = lines.map(() => 0);
  for (;;) {
    let next = Infinity;
    lines.forEach((line, i) => {
      next = Math.min(next, line.x[at[i] ?? 0] ?? Infinity);
    });
    if (next === Infinity) return [x, ...columns];
    x.push(next);
    lines.forEach((line, i) => {
      const index = at[i] ?? 0;
      if (line.x[index] !== next) {
        columns[i]?.push(undefined);
        return;
      }
      const value = line.y[index] ?? NaN;
      columns[i]?.push(Number.isFinite(value) ? value : null);
      at[i] = index + 1;
    });
  }
}
