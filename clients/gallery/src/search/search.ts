// The search of a saved page: the page itself answers queries, forms groups and sorts by likeness,
// using an archive's index file.
//
// Answers equal those of clients/browse bit for bit (compared by tests/programs/test_gallery_search.py).
// Requests may overlap, and no part of the work blocks the page. Functions throw a SourceError of kind
// "aborted" if the signal is aborted, "torn" for an invalid file, or "other" for an invalid request.

import type { Packed } from "../data/packed";
import { type AskOptions, SourceError } from "../data/source";
import type { AlikeAnswer } from "../data/types";
import { Comparison } from "./comparing";
import { type AlikeGroups, GroupedSet, type Grouping } from "./groups";
import { parseQuery, type QueryError } from "./parse";
import { find } from "./query";
import { readIndex, type SearchIndex } from "./search-index";
import { coveredDurationS, type Sketch } from "./sketch";
import { Turns } from "./turns";

/** The server's limits. */
const GROUPS_MAX = 500;
const ALIKE_TO_MAX = 100;

export class ArchiveSearch {
  /** The set of the last request for groups. */
  private grouped: GroupedSet | null = null;

  private constructor(private readonly index: SearchIndex) {}

  static async of(packed: Packed): Promise<ArchiveSearch> {
    return new ArchiveSearch(await readIndex(packed, new Turns()));
  }

  get generation(): number {
    return this.index.generation;
  }

  /** Matching entries, ascending; an empty query matches all. */
  async find(query: string, options: AskOptions = {}): Promise<readonly number[] | QueryError> {
    if (/^[ \t\r\n]*$/.test(query)) return allOf(this.index);
    const condition = parseQuery(query, { features: this.index.features, numbers: this.index.numberNames });
    if ("message" in condition) return condition;
    return find(condition, this.index, new Turns(options.signal));
  }

  /** Groups of the entries, or of all. */
  async groups(
    entries: readonly number[] | null, groups: number, by: Grouping, options: AskOptions = {},
  ): Promise<AlikeGroups> {
    if (!Number.isInteger(groups) || groups < 1 || groups > GROUPS_MAX)
      throw new SourceError("other", `The number of groups must be 1 to ${GROUPS_MAX}.`);
    const meant = this.meant(entries);
    if (meant.length === 0) return { groups: [], approximate: false };
    const turns = new Turns(options.signal);
    const set = this.grouped?.isOf(meant) ? this.grouped : GroupedSet.of(this.index, meant);
    this.grouped = set;
    return set.divided(groups, by, turns);
  }

  /** The entries, or all, by distance to the nearest of `to`. */
  async alike(
    to: readonly number[], entries: readonly number[] | null, options: AskOptions = {},
  ): Promise<AlikeAnswer> {
    const chosen = this.meant(to);
    if (chosen.length === 0 || chosen.length > ALIKE_TO_MAX)
      throw new SourceError("other", `Sorting by likeness needs 1 to ${ALIKE_TO_MAX} animations.`);
    const meant = this.meant(entries);
    const turns = new Turns(options.signal);
    const comparison = new Comparison(this.index, coveredDurationS(this.index, allOf(this.index)));
    const sketches = chosen.map((entry): [number, Sketch] => [entry, comparison.sketch(entry)]);
    const found: { entry: number; distanceM: number }[] = [];
    for (const entry of meant) {
      const own = comparison.sketch(entry);
      let distanceM = Infinity;
      for (const [other, sketch] of sketches) {
        const apartM = entry < other ? comparison.valueM(own, sketch) : comparison.valueM(sketch, own);
        if (apartM < distanceM) distanceM = apartM;
        if (turns.isDue()) await turns.take();
      }
      found.push({ entry, distanceM });
    }
    found.sort((a, b) => a.distanceM - b.distanceM || a.entry - b.entry);
    return { entries: found.map((one) => one.entry), distance_m: found.map((one) => one.distanceM) };
  }

  /** The entries without duplicates. */
  private meant(entries: readonly number[] | null): readonly number[] {
    if (entries === null) return allOf(this.index);
    if (entries.some((entry) => !Number.isInteger(entry) || entry < 0 || entry >= this.index.entries))
      throw new SourceError("other", "An animation's entry is invalid.");
    return [...new Set(entries)];
  }
}

function allOf(index: SearchIndex): readonly number[] {
  return Array.from({ length: index.entries }, (_, entry) => entry);
}
