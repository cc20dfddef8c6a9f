// How large a share of a run's satisfied draws looks like a group's animations: what
// clients/gallery_server/shares.h says, with the same numbers, from the index's columns.

import { type Packed, torn } from "./packed";
import type { Entry } from "./types";

export interface Share {
  readonly value: number;
  /** Standard error, lineages being what is independent; NaN of fewer than two. */
  readonly error: number;
}

interface Lineage {
  /** Satisfied draws. */
  draws: number;
  /** By the animation they are put to. */
  readonly counts: { readonly entry: Entry; readonly draws: number }[];
}

export class SatisfiedDraws {
  private readonly draws: number;

  private constructor(private readonly lineages: readonly Lineage[], private readonly entries: number) {
    this.draws = lineages.reduce((sum, lineage) => sum + lineage.draws, 0);
  }

  /** `packed`: the index. Without its column "satisfied_draws" nothing was counted: null. */
  static of(packed: Packed): SatisfiedDraws | null {
    const { columns } = packed;
    const counts = columns.get("satisfied_draws");
    if (counts === undefined) return null;
    const chain = columns.get("chain");
    const lineage = columns.get("lineage");
    if (chain?.length !== counts.length || lineage?.length !== counts.length)
      throw torn("the index's columns differ in length");
    const entries = [...counts.keys()].filter((entry) => counts[entry]! > 0);
    // Sums go in this order, as the server's do.
    entries.sort((a, b) => chain[a]! - chain[b]! || lineage[a]! - lineage[b]! || a - b);
    const lineages: Lineage[] = [];
    entries.forEach((entry, i) => {
      const before = entries[i - 1];
      const isNew = before === undefined || chain[before] !== chain[entry] ||
        lineage[before] !== lineage[entry];
      if (isNew) lineages.push({ draws: 0, counts: [] });
      const last = lineages.at(-1)!;
      last.draws += counts[entry]!;
      last.counts.push({ entry, draws: counts[entry]! });
    });
    return new SatisfiedDraws(lineages, counts.length);
  }

  /** Of groups of different entries; null: there is no draw. */
  shares(groups: readonly (readonly Entry[])[]): readonly Share[] | null {
    if (this.draws === 0) return null;
    const groupOf = new Int32Array(this.entries).fill(-1);
    groups.forEach((members, group) => {
      for (const entry of members) groupOf[entry] = group;
    });
    // Of each group those lineages that have any of it: their draws, and the group's among them.
    const parts = groups.map((): { size: number; own: number }[] => []);
    let squares = 0;
    for (const lineage of this.lineages) {
      squares += lineage.draws * lineage.draws;
      const here = new Map<number, number>();
      for (const { entry, draws } of lineage.counts) {
        const group = groupOf[entry]!;
        if (group >= 0) here.set(group, (here.get(group) ?? 0) + draws);
      }
      for (const [group, own] of here) parts[group]!.push({ size: lineage.draws, own });
    }
    const count = this.lineages.length;
    return parts.map((part) => {
      const value = part.reduce((sum, { own }) => sum + own, 0) / this.draws;
      // Lineages without any of the group deviate by value * size.
      let deviations = value * value * (squares - part.reduce((sum, { size }) => sum + size * size, 0));
      for (const { size, own } of part) deviations += (own - value * size) ** 2;
      const error = count < 2 ? NaN : Math.sqrt((count / (count - 1)) * deviations) / this.draws;
      return { value, error };
    });
  }
}
