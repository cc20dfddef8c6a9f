// Finds medoids: k members with a small sum of distances from all members to the nearest medoid. Medoids are
// chosen one by one, then exchanged while this lowers the sum (references: clients/browse/groups.h). The
// first of equal choices is taken, and sums have the same order as in clients/browse/groups.cpp, so that
// saved pages form the same groups as served ones.

import type { Turns } from "./turns";

/** Distances between the members of a set, row by row. */
export interface Matrix {
  readonly size: number;
  readonly values: Float32Array;
}

/** In ascending order. REQUIRES: 1 <= k <= size. */
export async function medoidsOf(matrix: Matrix, k: number, turns: Turns): Promise<number[]> {
  const medoids = await firstMedoids(matrix, k, turns);
  // Exchanges need a second nearest medoid. For k = 1, the first choice is already optimal.
  while (k > 1 && k < matrix.size && exchange(matrix, medoids)) if (turns.isDue()) await turns.take();
  return medoids.sort((a, b) => a - b);
}

/** Each next medoid is the point that lowers the sum of distances most. */
async function firstMedoids({ size, values }: Matrix, k: number, turns: Turns): Promise<number[]> {
  const medoids: number[] = [];
  const isMedoid = new Uint8Array(size);
  const nearest = new Float32Array(size).fill(Infinity);
  for (let i = 0; i < k; ++i) {
    let best = -1;
    let bestSum = Infinity;
    for (let candidate = 0; candidate < size; ++candidate) {
      if (isMedoid[candidate] !== 0) continue;
      const row = candidate * size;
      let sum = 0;
      for (let point = 0; point < size; ++point) {
        const distance = values[row + point]!;
        const before = nearest[point]!;
        sum += distance < before ? distance : before;
      }
      if (sum < bestSum) [bestSum, best] = [sum, candidate];
    }
    medoids.push(best);
    isMedoid[best] = 1;
    for (let point = 0; point < size; ++point) {
      const distance = values[best * size + point]!;
      if (distance < nearest[point]!) nearest[point] = distance;
    }
    if (turns.isDue()) await turns.take();
  }
  return medoids;
}

/** For each point: the index of its nearest medoid in the list, and the distances to this and the second
 *  nearest. */
interface Nearest {
  readonly medoid: Uint32Array;
  readonly distance: Float32Array;
  readonly second: Float32Array;
}

function nearestOf({ size, values }: Matrix, medoids: readonly number[]): Nearest {
  const medoid = new Uint32Array(size);
  const distance = new Float32Array(size).fill(Infinity);
  const second = new Float32Array(size).fill(Infinity);
  medoids.forEach((of, i) => {
    for (let point = 0; point < size; ++point) {
      const to = values[of * size + point]!;
      if (to < distance[point]!) {
        second[point] = distance[point]!;
        distance[point] = to;
        medoid[point] = i;
      } else if (to < second[point]!) {
        second[point] = to;
      }
    }
  });
  return { medoid, distance, second };
}

/** Performs the exchange of a medoid for another point that lowers the sum of distances most; returns false
 *  if no exchange lowers it. */
function exchange(matrix: Matrix, medoids: number[]): boolean {
  const { size, values } = matrix;
  const nearest = nearestOf(matrix, medoids);
  const { medoid, distance, second } = nearest;
  // Increase of the sum if a medoid is removed without replacement.
  const loss = new Float64Array(medoids.length);
  for (let point = 0; point < size; ++point)
    loss[medoid[point]!] = loss[medoid[point]!]! + (second[point]! - distance[point]!);
  const change = new Float64Array(medoids.length);
  let bestChange = 0;
  let bestOut = 0;
  let bestIn = -1;
  const isMedoid = new Set(medoids);
  for (let candidate = 0; candidate < size; ++candidate) {
    if (isMedoid.has(candidate)) continue;
    change.set(loss);
    const common = changes(values, candidate * size, nearest, change);
    let least = 0;
    for (let i = 1; i < change.length; ++i) if (change[i]! < change[least]!) least = i;
    if (common + change[least]! < bestChange) {
      bestChange = common + change[least]!;
      [bestOut, bestIn] = [least, candidate];
    }
  }
  // Ignore changes as small as rounding errors, which could repeat for ever.
  const total = distance.reduce((sum, one) => sum + one, 0);
  if (bestIn < 0 || -bestChange <= 1e-9 * total) return false;
  medoids[bestOut] = bestIn;
  return true;
}

/** The candidate's change of the sum for any removed medoid; adds each medoid's additional change to
 *  `change`. */
function changes(values: Float32Array, row: number, nearest: Nearest, change: Float64Array): number {
  const { medoid, distance, second } = nearest;
  let common = 0;
  for (let point = 0; point < distance.length; ++point) {
    const to = values[row + point]!;
    const first = distance[point]!;
    if (to < first) {
      common += to - first;
      const of = medoid[point]!;
      change[of] = change[of]! + (first - second[point]!);
    } else if (to < second[point]!) {
      const of = medoid[point]!;
      change[of] = change[of]! + (to - second[point]!);
    }
  }
  return common;
}
