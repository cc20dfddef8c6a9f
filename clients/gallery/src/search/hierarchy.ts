// Grouping by hierarchy: the two nearest groups are joined until k groups are left. The distance of groups is
// the mean distance of their members (average linkage by nearest-neighbour chains, as in Murtagh, The
// Computer Journal 26, 1983). The choices are the same as those of hierarchy_of in clients/browse/groups.cpp.

import type { Matrix } from "./medoids";

interface Merge {
  readonly distance: number;
  readonly a: number;
  readonly b: number;
}

/** The group (0 to k - 1) of each point. REQUIRES: 1 <= k <= size. */
export function hierarchyOf(matrix: Matrix, k: number): number[] {
  // Chains don't find the merges in order of distance, so the merges are sorted. The first `size - k` merges
  // then leave k groups. The sort is stable.
  const merges = mergesOf(matrix).sort((a, b) => a.distance - b.distance);
  const root = Array.from({ length: matrix.size }, (_, point) => point);
  const rootOf = (from: number): number => {
    let point = from;
    while (root[point] !== point) point = root[point] = root[root[point]!]!;
    return point;
  };
  for (const merge of merges.slice(0, matrix.size - k)) {
    const a = rootOf(merge.a);
    const b = rootOf(merge.b);
    root[Math.max(a, b)] = Math.min(a, b);
  }
  const numberOf = new Map<number, number>();
  return root.map((_, point) => {
    const of = rootOf(point);
    const number = numberOf.get(of) ?? numberOf.size;
    numberOf.set(of, number);
    return number;
  });
}

function mergesOf({ size, values }: Matrix): Merge[] {
  const between = values.slice();
  const members = new Float64Array(size).fill(1);
  const isThere = new Uint8Array(size).fill(1);
  const merges: Merge[] = [];
  const chain: number[] = [];
  while (merges.length + 1 < size) {
    if (chain.length === 0) chain.push(isThere.indexOf(1));
    const last = chain[chain.length - 1]!;
    const before = chain.length > 1 ? chain[chain.length - 2]! : -1;
    const { nearest, distance } = nearestTo(between, isThere, last, before);
    if (nearest !== before) {
      chain.push(nearest);
      continue;
    }
    // The chain's last two groups are each other's nearest neighbours.
    chain.length -= 2;
    const kept = Math.min(last, nearest);
    const gone = Math.max(last, nearest);
    merges.push({ distance, a: kept, b: gone });
    const keptMembers = members[kept]!;
    const goneMembers = members[gone]!;
    for (let other = 0; other < size; ++other) {
      if (other === kept || other === gone || isThere[other] === 0) continue;
      const sum = keptMembers * between[kept * size + other]! + goneMembers * between[gone * size + other]!;
      const mean = sum / (keptMembers + goneMembers);
      between[kept * size + other] = mean;
      between[other * size + kept] = mean;
    }
    members[kept] = keptMembers + goneMembers;
    isThere[gone] = 0;
  }
  return merges;
}

/** The previous group in the chain (-1: none), unless another is nearer; of equally near groups the first. */
function nearestTo(
  between: Float32Array, isThere: Uint8Array, last: number, before: number,
): { nearest: number; distance: number } {
  const size = isThere.length;
  let nearest = before;
  let distance = before < 0 ? Infinity : between[last * size + before]!;
  for (let other = 0; other < size; ++other) {
    if (other === last || isThere[other] === 0) continue;
    const to = between[last * size + other]!;
    if (to < distance || nearest < 0) [distance, nearest] = [to, other];
  }
  return { nearest, distance };
}
