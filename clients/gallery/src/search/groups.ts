// Groups of similar animations, each with a representative. clients/browse/groups.h defines groups, and the
// sampling of sets above 500 animations. The results equal those of clients/browse/groups.cpp.

import { byName, Comparison, evenlyChosen, FULL_MATRIX_MAX, sampleSize } from "./comparing";
import { hierarchyOf } from "./hierarchy";
import { type Matrix, medoidsOf } from "./medoids";
import type { SearchIndex } from "./search-index";
import { coveredDurationS } from "./sketch";
import type { Turns } from "./turns";

export type Grouping = "medoids" | "hierarchy";

export interface AlikeGroup {
  readonly representative: number;
  /** In the order of names, including the representative. */
  readonly members: readonly number[];
  /** Distances of the members from the representative. */
  readonly mean_m: number;
  readonly greatest_m: number;
}

export interface AlikeGroups {
  /** From largest to smallest; groups of equal size by representative. */
  readonly groups: readonly AlikeGroup[];
  /** Whether groups come from a sample. */
  readonly approximate: boolean;
}

/** A set that can be grouped in different ways. */
export class GroupedSet {
  /** Samples by their size. */
  private readonly samples = new Map<number, Sample>();

  private constructor(
    private readonly index: SearchIndex,
    private readonly comparison: Comparison,
    /** The whole set, in the order of names. */
    private readonly entries: readonly number[],
  ) {}

  /** REQUIRES: at least one entry; all entries are different. */
  static of(index: SearchIndex, entries: readonly number[]): GroupedSet {
    const sorted = [...entries].sort((a, b) => byName(index, a, b));
    return new GroupedSet(index, new Comparison(index, coveredDurationS(index, sorted)), sorted);
  }

  isOf(entries: readonly number[]): boolean {
    if (entries.length !== this.entries.length) return false;
    const mine = new Set(this.entries);
    return entries.every((entry) => mine.has(entry));
  }

  /** REQUIRES: 1 <= groups. */
  async divided(groups: number, by: Grouping, turns: Turns): Promise<AlikeGroups> {
    const { places, matrix } = await this.sampleFor(groups, turns);
    const k = Math.min(groups, places.length);
    const groupOf = new Map<number, number>();
    let representatives: number[];
    if (by === "medoids") {
      representatives = (await medoidsOf(matrix, k, turns)).map((member) => places[member]!);
    } else {
      const ofSample = hierarchyOf(matrix, k);
      ofSample.forEach((group, member) => groupOf.set(places[member]!, group));
      representatives = membersOf(ofSample, k).map((members) => places[centralMember(matrix, members)]!);
    }
    const found = await this.filled(representatives, groupOf, turns);
    found.sort((a, b) => b.members.length - a.members.length || a.place - b.place);
    const answer = found.map(({ place, members, sumM, greatestM }): AlikeGroup => ({
      representative: this.entries[place]!,
      members,
      mean_m: sumM / members.length,
      greatest_m: greatestM,
    }));
    return { groups: answer, approximate: this.entries.length > FULL_MATRIX_MAX };
  }

  private async sampleFor(groups: number, turns: Turns): Promise<Sample> {
    const { index, entries } = this;
    const size = sampleSize(entries.length, groups);
    const known = this.samples.get(size);
    if (known !== undefined) return known;
    const chosen = size < entries.length ? await evenlyChosen(index, entries, size, turns) : entries;
    const isChosen = new Set(chosen);
    const places = [...entries.keys()].filter((place) => isChosen.has(entries[place]!));
    const made = { places, matrix: await this.comparison.matrix(chosen, turns) };
    this.samples.set(size, made);
    return made;
  }

  /** Assigns all entries to groups: sampled ones by the grouping, the others to the nearest representative. */
  private async filled(
    representatives: readonly number[], groupOf: ReadonlyMap<number, number>, turns: Turns,
  ): Promise<Filled[]> {
    const groups = representatives.map((place): Filled => ({ place, members: [], sumM: 0, greatestM: 0 }));
    const sketches = representatives.map((place) => this.comparison.sketch(this.entries[place]!));
    for (let place = 0; place < this.entries.length; ++place) {
      const own = this.comparison.sketch(this.entries[place]!);
      const apartM = (group: number): number => {
        const other = representatives[group]!;
        if (other === place) return -1;
        return place < other
          ? this.comparison.valueM(own, sketches[group]!) : this.comparison.valueM(sketches[group]!, own);
      };
      let group = groupOf.get(place) ?? 0;
      let leastM = apartM(group);
      for (let other = 1; other < groups.length && !groupOf.has(place); ++other) {
        const distanceM = apartM(other);
        if (distanceM < leastM) [leastM, group] = [distanceM, other];
        if (turns.isDue()) await turns.take();
      }
      const to = groups[group]!;
      to.members.push(this.entries[place]!);
      to.sumM += Math.max(0, leastM);
      to.greatestM = Math.max(to.greatestM, leastM);
      if (turns.isDue()) await turns.take();
    }
    return groups;
  }
}

/** Entries that are compared with one another. */
interface Sample {
  /** Indices in `entries`; ascending. */
  readonly places: readonly number[];
  readonly matrix: Matrix;
}

interface Filled {
  /** The representative's index in the set. */
  readonly place: number;
  readonly members: number[];
  sumM: number;
  greatestM: number;
}

function membersOf(groupOf: readonly number[], k: number): number[][] {
  const members = Array.from({ length: k }, (): number[] => []);
  groupOf.forEach((group, member) => members[group]!.push(member));
  return members;
}

/** The member with the smallest sum of distances to the others. */
function centralMember({ size, values }: Matrix, members: readonly number[]): number {
  let best = members[0]!;
  let bestSum = Infinity;
  for (const member of members) {
    let sum = 0;
    for (const other of members) sum += values[member * size + other]!;
    if (sum < bestSum) [bestSum, best] = [sum, member];
  }
  return best;
}
