// What follows from the state. Each is computed once for the parts that it depends on.
import { noteOf } from "../data/note-patch";
import type { ArchiveSummary } from "../data/types";
import { noEntries, type AppState, type QueryAnswer } from "./app-state";
import { difference, filtered, intersection, type Entries } from "./entry-sets";
import { isLetThrough } from "./notes";
import type { Chip } from "./page";
import { joined, type SignedQuery } from "./query-text";
import { sortedByNumber } from "./sorting";

/** How many states are looked at in turn: the one that is shown and the one before it. */
const rememberedMax = 3;

/** Remembers the last results for as long as the parts stay the same things. */
function remembered<Parts extends readonly unknown[], Result>(
  partsOf: (state: AppState) => Parts,
  compute: (state: AppState) => Result,
): (state: AppState) => Result {
  let last: readonly { parts: Parts; result: Result }[] = [];
  return (state) => {
    const parts = partsOf(state);
    const known = last.find((other) => parts.every((part, i) => part === other.parts[i]));
    if (known !== undefined) return known.result;
    const result = compute(state);
    last = [{ parts, result }, ...last].slice(0, rememberedMax);
    return result;
  };
}

/** What the queries' chips that are on let through, of what is shown at all. */
export const queried = remembered(
  (state) => [state.visible, state.page.chips, state.answers] as const,
  (state) => withChips(state.visible, state.page.chips, state.answers),
);

/** Chips that aren't answered, or are wrong, let all through. */
export function withChips(
  entries: Entries,
  chips: readonly Chip[],
  answers: ReadonlyMap<string, QueryAnswer>,
): Entries {
  let left = entries;
  for (const chip of chips) {
    const found = chip.isOn ? answers.get(chip.text)?.entries : null;
    if (found) left = chip.isNot ? difference(left, found) : intersection(left, found);
  }
  return left;
}

/** ... and what the filter of notes lets through. */
export const passed = remembered(
  (state) => [queried(state), state.notes, state.page.notesFilter, state.loaded] as const,
  (state) => notesPassed(state, queried(state)),
);

function notesPassed(state: AppState, entries: Entries): Entries {
  const names = state.loaded?.names ?? [];
  return filtered(entries, (entry) =>
    isLetThrough(noteOf(state.notes, names[entry] ?? ""), state.page.notesFilter),
  );
}

/** Of what is shown at all, how many the notes' filter hides because they are marked as hidden. */
export const hiddenCount = remembered(
  (state) => [state.visible, state.notes, state.loaded] as const,
  (state) => {
    const names = state.loaded?.names ?? [];
    return filtered(state.visible, (entry) => noteOf(state.notes, names[entry] ?? "").hidden).length;
  },
);

/** ... and is in the group that is open: what the wall shows. */
export const within = remembered(
  (state) => [passed(state), state.opened] as const,
  (state) => {
    let entries = passed(state);
    for (const members of state.opened) entries = intersection(entries, members ?? noEntries);
    return entries;
  },
);

/** The same in the order that is asked for. */
export const ordered = remembered(
  (state) => [within(state), state.page.sort, state.distances, state.loaded] as const,
  (state): Entries => {
    const { sort } = state.page;
    const entries = within(state);
    if (sort.by === "number") {
      const column = state.loaded?.table.numbers.get(sort.number);
      return column === undefined ? entries : sortedByNumber(entries, column, sort.isDescending);
    }
    if (sort.by === "alike" && state.distances !== null)
      return sortedByNumber(entries, state.distances.byEntry, sort.isUnlike);
    return entries;
  },
);

/** The names in that order. */
export const orderedNames = remembered(
  (state) => [ordered(state), state.loaded] as const,
  (state): readonly string[] => {
    const names = state.loaded?.names ?? [];
    return Array.from(ordered(state), (entry) => names[entry] ?? "");
  },
);

/** Whether the groups are those of what is shown, made as is asked for. */
export function areGroupsThere(state: AppState): boolean {
  const { groups: shown, page } = state;
  const { groups, by } = page.grouping;
  return shown !== null && shown.ask.groups === groups && shown.ask.by === by && isSame(shown.of, within(state));
}

function isSame(a: Entries, b: Entries): boolean {
  return a === b || (a.length === b.length && a.every((entry, i) => entry === b[i]));
}

export interface ChipCounts {
  /** That are meant by it alone; null: not answered yet. */
  readonly alone: number | null;
  /** Left if it is applied to all that the others let through, as IN and as NOT-IN. */
  readonly asIn: number | null;
  readonly asNot: number | null;
}

/** Of a text that is not applied yet, or of a chip (`id`), which then isn't counted among the others. */
export function countsOf(state: AppState, text: string, id: number | null): ChipCounts {
  const found = state.answers.get(text)?.entries ?? null;
  if (found === null) return { alone: null, asIn: null, asNot: null };
  const others = state.page.chips.filter((chip) => chip.id !== id);
  const rest = notesPassed(state, withChips(state.visible, others, state.answers));
  const asIn = intersection(rest, found).length;
  return { alone: intersection(state.visible, found).length, asIn, asNot: rest.length - asIn };
}

export function signedQueries(chips: readonly Chip[]): SignedQuery[] {
  return chips.filter((chip) => chip.isOn).map(({ text, isNot }) => ({ text, isNot }));
}

/** All chips that are on, as one query; "" of none. */
export function wholeQuery(chips: readonly Chip[]): string {
  return joined(signedQueries(chips));
}

/** Where the archive's run is still there as it is now, else as it was when it was read last. */
export function archiveShown(state: AppState): ArchiveSummary | null {
  const { gallery, loaded } = state;
  if (loaded === null) return null;
  if (replacing(state) !== null) return { ...loaded.archive, is_live: false, live_words: "" };
  return gallery?.archives.find(({ id }) => id === loaded.id) ?? null;
}

/** Another run's archive that has come to be in the place of the one that is shown. */
export function replacing({ gallery, loaded }: AppState): ArchiveSummary | null {
  const archive = gallery?.archives.find(({ id }) => id === loaded?.id);
  // Of one that is read for the first time since a server began the run isn't known yet.
  const isOther = archive !== undefined && archive.run !== "" && archive.run !== loaded?.run;
  return isOther ? archive : null;
}

/** How many animations have come that are not shown yet. */
export function offeredCount(state: AppState): number {
  return Math.max(0, (state.loaded?.names.length ?? 0) - state.visible.length);
}

/** What is chosen, else nothing: what keys and buttons act on. */
export function actedOn(state: AppState, focused: string | null): readonly string[] {
  if (state.selection.names.length > 0) return state.selection.names;
  return focused === null ? [] : [focused];
}
