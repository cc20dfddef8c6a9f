// Distances between animations of a set, made ready once: asking for another number of groups of the
// same set computes no distance anew.

import type { Matrix } from "./medoids";
import { Resemblance } from "./resemblance";
import type { SearchIndex } from "./search-index";
import { sha256Hex } from "./sha256";
import { type Sketch, sketchOf } from "./sketch";
import type { Turns } from "./turns";

/** Largest set whose full matrix is computed. */
export const FULL_MATRIX_MAX = 500;
/** Of a larger set, so many stand for all, while no more groups than this are asked for. */
const SAMPLE = 200;
const GROUPS_OF_SAMPLE_MAX = 100;

/** How many of a set are compared with one another, for so many groups. */
export function sampleSize(entries: number, groups: number): number {
  if (entries <= FULL_MATRIX_MAX) return entries;
  return groups <= GROUPS_OF_SAMPLE_MAX ? SAMPLE : FULL_MATRIX_MAX;
}

/** In the order of their names: finds behind all others. */
export function byName(index: SearchIndex, a: number, b: number): number {
  return index.isFind[a]! - index.isFind[b]! || index.chain[a]! - index.chain[b]! ||
    index.draw[a]! - index.draw[b]!;
}

/**
 * So many of the entries, chosen by a hash of their names: as even as a draw, and the same in whatever
 * order they are given. By name.
 */
export async function evenlyChosen(
  index: SearchIndex, entries: readonly number[], count: number, turns: Turns,
): Promise<number[]> {
  const hashed: { hash: string; entry: number }[] = [];
  for (const entry of entries) {
    // As names once were: "0.250".
    hashed.push({ hash: sha256Hex(`${index.run}\n${index.names[entry]!.replace(/^c/, "")}`), entry });
    if (turns.isDue()) await turns.take();
  }
  hashed.sort((a, b) => a.hash < b.hash ? -1 : 1);
  return hashed.slice(0, count).map(({ entry }) => entry).sort((a, b) => byName(index, a, b));
}

/** Some entries of an index, compared up to the same time. */
export class Comparison {
  private readonly resemblance: Resemblance;
  private readonly sketches = new Map<number, Sketch>();

  constructor(private readonly index: SearchIndex, private readonly durationS: number) {
    this.resemblance = new Resemblance(index);
  }

  /** Keeps the sketch: of entries that are compared with many. */
  keep(entry: number): void {
    if (!this.sketches.has(entry)) this.sketches.set(entry, this.sketch(entry));
  }

  /** Not kept, unless it is already: sketches of thousands of animations are hundreds of megabytes. */
  sketch(entry: number): Sketch {
    return this.sketches.get(entry) ?? sketchOf(this.index, entry, this.durationS);
  }

  /** In metres. REQUIRES: a comes before b in the list that is compared. */
  valueM(a: Sketch, b: Sketch): number {
    return this.resemblance.valueM(a, b);
  }

  /** Of all pairs. Keeps their sketches. */
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
