// Divides a picture into rows and columns for up to nine animations, as large as possible. Pure.

export interface Cell {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

export const CELLS_MAX = 9;
/** Typical width / height of a scene's picture. */
const ASPECT = 1.35;
/** Pixels between cells. */
const GAP = 4;

/** Cells from the upper left, row by row, in whole pixels. */
export function cellsOf(count: number, width: number, height: number): Cell[] {
  if (count < 1 || width < 1 || height < 1) return [];
  let columns = 1;
  let best = 0;
  for (let c = 1; c <= count; ++c) {
    const rows = Math.ceil(count / c);
    const size = Math.min(width / c / ASPECT, height / rows);
    if (size > best + 1e-9) {
      best = size;
      columns = c;
    }
  }
  const rows = Math.ceil(count / columns);
  const edge = (i: number, n: number, size: number): number => Math.round((i * (size + GAP)) / n);
  const cells: Cell[] = [];
  for (let i = 0; i < count; ++i) {
    const column = i % columns;
    const row = Math.floor(i / columns);
    const x = edge(column, columns, width);
    const y = edge(row, rows, height);
    cells.push({
      x, y,
      width: Math.max(edge(column + 1, columns, width) - GAP - x, 1),
      height: Math.max(edge(row + 1, rows, height) - GAP - y, 1),
    });
  }
  return cells;
}

/** The cell that contains the point; -1: none. */
export function cellAt(cells: readonly Cell[], x: number, y: number): number {
  return cells.findIndex((cell) =>
    x >= cell.x && x < cell.x + cell.width && y >= cell.y && y < cell.y + cell.height);
}
