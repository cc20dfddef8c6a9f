import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { test } from "node:test";
import { unpack } from "../src/data/packed";
import { SourceError } from "../src/data/source";
import { byName, Comparison, evenlyChosen } from "../src/search/comparing";
import { hierarchyOf } from "../src/search/hierarchy";
import { cheapestMatching } from "../src/search/matching";
import { type Matrix, medoidsOf } from "../src/search/medoids";
import { ArchiveSearch } from "../src/search/search";
import { sha256Hex } from "../src/search/sha256";
import { Turns } from "../src/search/turns";
import { indexBytes, indexOf, type MadeEntry, randomEntry, randomNumbers } from "./search-scene";

const SEED = 26;

function made(count: number): MadeEntry[] {
  const random = randomNumbers(SEED);
  return Array.from({ length: count }, (_, draw) => randomEntry(draw, random));
}

function searchOf(entries: readonly MadeEntry[]): Promise<ArchiveSearch> {
  return ArchiveSearch.of(unpack(indexBytes(entries).buffer as ArrayBuffer));
}

/** Points of the plane, about some middles. */
function randomMatrix(size: number, middles: number, random: () => number): Matrix {
  const points = Array.from({ length: size }, (_, i) =>
    [10 * (i % middles) + random(), 7 * ((i % middles) % 3) + random()] as const);
  const values = new Float32Array(size * size);
  points.forEach(([x, y], i) => points.forEach(([u, v], j) => {
    values[i * size + j] = Math.hypot(x - u, y - v);
  }));
  return { size, values };
}

function costOf({ size, values }: Matrix, medoids: readonly number[]): number {
  let sum = 0;
  for (let point = 0; point < size; ++point)
    sum += Math.min(...medoids.map((medoid) => values[medoid * size + point]!));
  return sum;
}

function* subsets(size: number, k: number, first = 0): Generator<number[]> {
  if (k === 0) yield [];
  for (let one = first; k > 0 && one < size; ++one)
    for (const rest of subsets(size, k - 1, one + 1)) yield [one, ...rest];
}

test("SHA-256 is SHA-256", () => {
  // Goal: the hash that chooses. Method: node's own, of all lengths about a block's end.
  for (let length = 0; length < 200; ++length) {
    const text = "é1f".repeat(length).slice(0, length);
    assert.equal(sha256Hex(text), createHash("sha256").update(text).digest("hex"), text);
  }
});

test("the cheapest matching is the cheapest", () => {
  // Goal: the assignment problem. Method: all permutations of up to six, some with equal costs.
  const random = randomNumbers(SEED);
  const without = (list: readonly number[], one: number): number[] => list.filter((other) => other !== one);
  const permutations = (list: readonly number[]): number[][] => list.length === 0 ? [[]]
    : list.flatMap((one) => permutations(without(list, one)).map((rest) => [one, ...rest]));
  for (let n = 0; n < 300; ++n) {
    const size = 1 + n % 6;
    const oneCost = (): number => n % 2 ? random() : Math.floor(4 * random());
    const costs = Float64Array.from({ length: size * size }, oneCost);
    const columnOf = new Int32Array(size);
    cheapestMatching(costs, size, columnOf);
    const cost = (columns: ArrayLike<number>): number =>
      Array.from(columns).reduce((sum, column, row) => sum + costs[row * size + column]!, 0);
    assert.equal(new Set(columnOf).size, size);
    const least = Math.min(...permutations([...Array(size).keys()]).map(cost));
    assert.ok(Math.abs(cost(columnOf) - least) < 1e-12, `case ${n} of seed ${SEED}`);
  }
});

test("medoids of small sets are the best there are", async () => {
  // Goal: choosing and exchanging. Method: sets in clear clumps, beside all choices of k.
  const random = randomNumbers(SEED);
  for (let n = 0; n < 60; ++n) {
    const k = 1 + n % 4;
    const matrix = randomMatrix(6 + n % 7, k, random);
    const medoids = await medoidsOf(matrix, k, new Turns());
    const best = Math.min(...[...subsets(matrix.size, k)].map((some) => costOf(matrix, some)));
    assert.ok(costOf(matrix, medoids) <= best * (1 + 1e-9), `case ${n} of seed ${SEED}`);
    assert.deepEqual(medoids, [...medoids].sort((a, b) => a - b));
  }
  const all = randomMatrix(5, 2, random);
  assert.deepEqual(await medoidsOf(all, 5, new Turns()), [0, 1, 2, 3, 4]);
});

test("hierarchies are those of merging the two nearest", () => {
  // Goal: chains of nearest neighbours. Method: looking for the two nearest groups anew each time.
  const random = randomNumbers(SEED);
  for (let n = 0; n < 60; ++n) {
    const matrix = randomMatrix(2 + n % 9, 1 + n % 4, random);
    const { size, values } = matrix;
    let groups = Array.from({ length: size }, (_, point) => [point]);
    for (let k = size; k >= 1; --k) {
      const numbers = hierarchyOf(matrix, k);
      const expected = new Array<number>(size);
      const inOrder = [...groups].sort((a, b) => a[0]! - b[0]!);
      inOrder.forEach((group, i) => group.forEach((at) => { expected[at] = i; }));
      assert.deepEqual(numbers, expected, `case ${n} of seed ${SEED}, ${k} groups`);
      const apart = (a: number[], b: number[]): number =>
        a.flatMap((i) => b.map((j) => values[i * size + j]!)).reduce((x, y) => x + y, 0) /
        (a.length * b.length);
      const pairs = [...subsets(groups.length, 2)].map(([i, j]) => [groups[i!]!, groups[j!]!] as const);
      const nearest = pairs.sort((a, b) => apart(...a) - apart(...b))[0];
      if (nearest === undefined) break;
      const merged = [...nearest[0], ...nearest[1]].sort((a, b) => a - b);
      groups = [merged, ...groups.filter((group) => !nearest.includes(group))];
    }
  }
});

test("what is alike, is near", async () => {
  // Goal: the measure's plain properties. Method: an animation, its copy, its copy with twins exchanged,
  // the same moved by 10 mm, another order of hits.
  const path = [{ start: 0, p: [0, 0, 1], v: [1, 0, 0] }, { start: 0.5, p: [0.5, 0, 1] }] as const;
  const other = [{ start: 0, p: [0, 0.5, 1] }] as const;
  const moved = path.map((piece) => ({ ...piece, p: [piece.p[0] + 0.01, 0, 1] as const }));
  const base = { end: 0.5, contacts: [[0.1, 0, 3], [0.2, 0, 4]], numbers: [0, 0, 0, 0, 0, 0] } as const;
  const index = await indexOf([
    { ...base, draw: 0, paths: [path, other, []] },
    { ...base, draw: 1, paths: [path, other, []] },
    { ...base, draw: 2, paths: [other, path, []], contacts: [[0.1, 1, 3], [0.2, 1, 4]] },
    { ...base, draw: 3, paths: [moved, other, []] },
    { ...base, draw: 4, paths: [moved, other, []], contacts: [[0.1, 0, 4], [0.2, 0, 3]] },
    { ...base, draw: 5, paths: [path, other, other] },
  ]);
  const comparison = new Comparison(index, 0.5);
  const apart = (a: number, b: number): number =>
    comparison.valueM(comparison.sketch(a), comparison.sketch(b));
  assert.equal(apart(0, 0), 0);
  assert.equal(apart(0, 1), 0);
  assert.equal(apart(0, 2), 0);
  // Of three bodies one is 10 mm away; of two contacts one keeps its order. Places are single precision.
  assert.ok(Math.abs(apart(0, 3) - 0.5 * (0.01 / 3 + 0.01)) < 1e-7);
  assert.ok(Math.abs(apart(0, 4) - 1.5 * apart(0, 3)) < 1e-12);
  // One that never enters is the view's diagonal away: 2, 2, 1 m.
  assert.ok(Math.abs(apart(0, 5) - 0.5 * (3 / 3 + 3)) < 1e-12);
});

test("groups divide a set, whatever its order, and are made again from what is known", async () => {
  // Goal: groups of sets within and above the full matrix. Method: 700 random animations.
  const search = await searchOf(made(700));
  const some = [5, 3, 9, 250, 17, 44];
  for (const [entries, by] of [[null, "medoids"], [null, "hierarchy"], [some, "medoids"]] as const) {
    const count = entries?.length ?? 700;
    const { groups, approximate } = await search.groups(entries, 4, by);
    assert.equal(approximate, count > 500);
    assert.deepEqual(groups.flatMap((group) => group.members).sort((a, b) => a - b),
      [...(entries ?? Array(700).keys())].sort((a, b) => a - b));
    for (const group of groups) assert.ok(group.members.includes(group.representative));
    const sizes = groups.map((group) => group.members.length);
    assert.deepEqual(sizes, [...sizes].sort((a, b) => b - a));
    const reversed = [...(entries ?? Array(700).keys())].reverse();
    assert.deepEqual(await (await searchOf(made(700))).groups(reversed, 4, by), { groups, approximate });
    assert.deepEqual(await search.groups(reversed, 4, by), { groups, approximate });
  }
  assert.deepEqual(await search.groups([], 4, "medoids"), { groups: [], approximate: false });
  await assert.rejects(search.groups([700], 1, "medoids"), SourceError);
  await assert.rejects(search.groups(null, 0, "medoids"), SourceError);
});

test("more like this: nearest first, itself before all", async () => {
  // Goal: alike's order and its several examples. Method: the nearest of each alone, put together.
  const search = await searchOf(made(60));
  const one = await search.alike([7], null);
  assert.deepEqual([one.entries[0], one.distance_m[0]], [7, 0]);
  assert.deepEqual(one.distance_m, [...one.distance_m].sort((a, b) => a - b));
  const other = await search.alike([30], null);
  const both = await search.alike([30, 7, 30], [1, 2, 3, 7]);
  const of = (answer: typeof one, entry: number): number => answer.distance_m[answer.entries.indexOf(entry)]!;
  for (const entry of [1, 2, 3, 7]) assert.equal(of(both, entry), Math.min(of(one, entry), of(other, entry)));
  assert.equal(both.entries.length, 4);
  await assert.rejects(search.alike([], null), SourceError);
});

test("a part is chosen by hash, whatever the order", async () => {
  // Goal: the sample of sets above 500. Method: node's hash; finds stand behind draws.
  const entries = made(40).map((entry, i) => ({ ...entry, isFind: i % 10 === 0 }));
  const index = await indexOf(entries);
  const all = [...entries.keys()];
  const chosen = await evenlyChosen(index, all, 15, new Turns());
  const hash = (entry: number): string =>
    createHash("sha256").update(`run\n${index.names[entry]!}`).digest("hex");
  const expected = [...all].sort((a, b) => hash(a) < hash(b) ? -1 : 1).slice(0, 15);
  assert.deepEqual(new Set(chosen), new Set(expected));
  assert.deepEqual(chosen, [...chosen].sort((a, b) => byName(index, a, b)));
  assert.deepEqual(await evenlyChosen(index, [...all].reverse(), 15, new Turns()), chosen);
  const kinds = chosen.map((entry) => index.isFind[entry]!);
  assert.deepEqual(kinds, [...kinds].sort());
});

test("long work gives way, and ends when it is no longer wanted", async () => {
  // Goal: the page has its turn, a question can be called off. Method: timers count while 400 are grouped.
  const search = await searchOf(made(400));
  let turns = 0;
  const timer = setInterval(() => ++turns, 1);
  await search.groups(null, 12, "medoids");
  clearInterval(timer);
  assert.ok(turns >= 2, `${turns}`);
  const stopped = new AbortController();
  const asked = (await searchOf(made(400))).groups(null, 12, "medoids", { signal: stopped.signal });
  setTimeout(() => stopped.abort(), 1);
  await assert.rejects(asked, (error) => error instanceof SourceError && error.kind === "aborted");
});
