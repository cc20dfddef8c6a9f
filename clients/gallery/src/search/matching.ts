// Solves the assignment problem by shortest augmenting paths (Jonker and Volgenant, Computing 38, 1987).
// Among equally cheap matchings, the choice is the same as that of CheapestMatching in
// clients/browse/matching.h.

/** Scratch memory shared by all matchings: there are hundreds of thousands, mostly of a few bodies. */
let room = 0;
let u = new Float64Array(0);
let v = new Float64Array(0);
let shortest = new Float64Array(0);
let rowOf = new Int32Array(0);
let cameFrom = new Int32Array(0);
let isDone = new Uint8Array(0);

function makeRoom(size: number): void {
  if (size < room) return;
  room = size + 1;
  u = new Float64Array(room);
  v = new Float64Array(room);
  shortest = new Float64Array(room);
  rowOf = new Int32Array(room);
  cameFrom = new Int32Array(room);
  isDone = new Uint8Array(room);
}

/** Sets the column of each row so that the sum of costs is minimal. REQUIRES: size^2 finite costs, row by
 *  row. */
export function cheapestMatching(costs: Float64Array, size: number, columnOf: Int32Array): void {
  makeRoom(size);
  // Rows and columns count from 1; 0 means none. rowOf[column] is the matched row. The potentials keep
  // cost[row][column] - u[row] - v[column] >= 0, with 0 for matched pairs.
  u.fill(0, 0, size + 1);
  v.fill(0, 0, size + 1);
  rowOf.fill(0, 0, size + 1);
  for (let row = 1; row <= size; ++row) {
    let column = freeColumn(costs, size, row);
    // Invert the path.
    while (column !== 0) {
      rowOf[column] = rowOf[cameFrom[column]!]!;
      column = cameFrom[column]!;
    }
  }
  for (let column = 1; column <= size; ++column) columnOf[rowOf[column]! - 1] = column - 1;
}

/** Grows a tree of shortest paths from the row until it reaches an unmatched column. */
function freeColumn(costs: Float64Array, size: number, row: number): number {
  shortest.fill(Infinity, 0, size + 1);
  isDone.fill(0, 0, size + 1);
  rowOf[0] = row;
  let column = 0;
  do {
    isDone[column] = 1;
    const from = rowOf[column]!;
    const before = (from - 1) * size - 1;
    const uFrom = u[from]!;
    let step = Infinity;
    let nearest = 0;
    for (let other = 1; other <= size; ++other) {
      if (isDone[other] !== 0) continue;
      const reduced = costs[before + other]! - uFrom - v[other]!;
      if (reduced < shortest[other]!) {
        shortest[other] = reduced;
        cameFrom[other] = column;
      }
      if (shortest[other]! < step) {
        step = shortest[other]!;
        nearest = other;
      }
    }
    for (let other = 0; other <= size; ++other) {
      if (isDone[other] !== 0) {
        const of = rowOf[other]!;
        u[of] = u[of]! + step;
        v[other] = v[other]! - step;
      } else {
        shortest[other] = shortest[other]! - step;
      }
    }
    column = nearest;
  } while (rowOf[column] !== 0);
  return column;
}
