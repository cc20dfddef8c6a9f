// Distances between the animations of a set. Each distance is computed only once, even if the number of
// groups changes.

import type { Matrix } from "./medoids";
import { Resemblance } from "./resemblance";
import type { SearchIndex } from "./search-index";
import { sha256Hex } from "./sha256";
import { type Sketch, sketchOf } from "./sketch";
import type { Turns } from "./turns";

/** Maximum size of a set whose full matrix is computed. */
export const FULL_MATRIX_MAX = 500;
/** Sample size for larger sets, up to this number of groups. */
const SAMPLE = 200;
const GROUPS_OF_SAMPLE_MAX = 100;

/** Number of animations to compare, for a set of `entries` animations. */
export function sampleSize(entries: number, groups: number): number {
  if (entries <= FULL_MATRIX_MAX) return entries;
  return groups <= GROUPS_OF_SAMPLE_MAX ? SAMPLE : FULL_MATRIX_MAX;
}

/** Compares entries by name; finds come last. */
export function byName(index: SearchIndex, a: number, b: number): number {
  return index.isFind[a]! - index.isFind[b]! || index.chain[a]! - index.chain[b]! ||
    index.draw[a]! - index.draw[b]!;
}

/** Selects `count` entries by a hash of their names: as even as a random draw, and independent of the
 *  entries' order. Returns them in the order of names. */
export async function evenlyChosen(
  index: SearchIndex, entries: readonly number[], count: number, turns: Turns,
): Promise<number[]> {
  const hashed: { hash: string; entry: number }[] = [];
  for (const entry of entries) {
    // Hashes the old form of names, such as "0.250".
    hashed.push({ hash: sha256Hex(`${index.run}\n${index.names[entry]!.replace(/^c/, "")}`), entry });
    if (turns.isDue()) await turns.take();
  }
  hashed.sort((a, b) => a.hash < b.hash ? -1 : 1);
  return hashed.slice(0, count).map(({ entry }) => entry).sort((a, b) => byName(index, a, b));
}

/** Compares entries of an index, up to a common time. */
export class Comparison {
  private readonly resemblance: Resemblance;
  private readonly sketches = new Map<number, Sketch>();

  constructor(private readonly index: SearchIndex, private readonly durationS: number) {
    this.resemblance = new Resemblance(index);
  }

  /** Stores the entry's sketch; for entries that are compared with many. */
  keep(entry: number): void {
    if (!this.sketches.has(entry)) this.sketches.set(entry, this.sketch(entry));
  }

  /** The entry's sketch, not stored: sketches of thousands of animations take hundreds of megabytes. */
  sketch(entry: number): Sketch {
    return this.sketches.get(entry) ?? sketchOf(this.index, entry, this.durationS);
  }

  /** Distance in metres. REQUIRES: a comes before b in the compared list. */
  valueM(a: Sketch, b: Sketch): number {
    return this.resemblance.valueM(a, b);
  }

  /** The distances of all pairs. Stores their sketches. */
  async matrix(entries: readonly number[], turns: Turns): Promise<Matrix> {
    const size = entries.length;
    const sketches: Sketch[] = [];
    for (const entry of entries) {
      this.keep(entry);
      sketches.push(this.sketch(entry));
      if (turns.isDue()) await turns.take();
    }
    const values = new Float32Array(size * size);
    for (let row = 0; row < size; ++row) {
      for (let column = row + 1; column < size; ++column) {
        const value = this.valueM(sketches[row]!, sketches[column]!);
        values[row * size + column] = value;
        values[column * size + row] = value;
        if (turns.isDue()) await turns.take();
      }
    }
    return { size, values };
  }
}
