// Each group's share of a run's satisfied draws, from the index's columns. The results equal those of
// clients/gallery_server/shares.h.

import { type Packed, torn } from "./packed";
import type { Entry } from "./types";

export interface Share {
  readonly value: number;
  /** Standard error with lineages as independent samples; NaN for fewer than two lineages. */
  readonly error: number;
}

interface Lineage {
  /** Number of satisfied draws. */
  draws: number;
  /** Satisfied draws by the animation that they are assigned to. */
  readonly counts: { readonly entry: Entry; readonly draws: number }[];
}

export class SatisfiedDraws {
  private readonly draws: number;

  private constructor(private readonly lineages: readonly Lineage[], private readonly entries: number) {
    this.draws = lineages.reduce((sum, lineage) => sum + lineage.draws, 0);
  }

  /** `packed` is the index. null if the index has no column "satisfied_draws". */
  static of(packed: Packed): SatisfiedDraws | null {
    const { columns } = packed;
    const counts = columns.get("satisfied_draws");
    if (counts === undefined) return null;
    const chain = columns.get("chain");
    const lineage = columns.get("lineage");
    if (chain?.length !== counts.length || lineage?.length !== counts.length)
      throw torn("the index's columns differ in length");
    const entries = [...counts.keys()].filter((entry) => counts[entry]! > 0);
    // Sum in the same order as the server.
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

  /** Shares of disjoint groups; null if there are no draws. */
  shares(groups: readonly (readonly Entry[])[]): readonly Share[] | null {
    if (this.draws === 0) return null;
    const groupOf = new Int32Array(this.entries).fill(-1);
    groups.forEach((members, group) => {
      for (const entry of members) groupOf[entry] = group;
    });
    // For each group and each of its lineages: the lineage's draws, and the group's part of these draws.
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
      // In lineages without draws of the group, the deviation is `value * size`.
      let deviations = value * value * (squares - part.reduce((sum, { size }) => sum + size * size, 0));
      for (const { size, own } of part) deviations += (own - value * size) ** 2;
      const error = count < 2 ? NaN : Math.sqrt((count / (count - 1)) * deviations) / this.draws;
      return { value, error };
    });
  }
}
