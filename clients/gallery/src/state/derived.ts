// Values derived from the state. A value is computed again only when the parts of the state that it depends
// on change.
import { noteOf } from "../data/note-patch";
import type { ArchiveSummary } from "../data/types";
import { noEntries, type AppState, type QueryAnswer } from "./app-state";
import { difference, intersection, type Entries } from "./entry-sets";
import { isLetThrough } from "./notes";
import type { Chip } from "./page";
import { joined, type SignedQuery } from "./query-text";
import { sortedByNumber } from "./sorting";

/** Number of cached results: two states (shown and previous) are used in turn. */
const rememberedMax = 3;

/** Caches results by the identity of the parts. */
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

/** The visible entries that match all chips that are on. */
export const queried = remembered(
  (state) => [state.visible, state.page.chips, state.answers] as const,
  (state) => withChips(state.visible, state.page.chips, state.answers),
);

/** Chips without an answer, or with an error, match all entries. */
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

/** The entries of queried() that the notes filter shows. */
export const passed = remembered(
  (state) => [queried(state), state.notes, state.page.notesFilter, state.loaded] as const,
  (state) => notesPassed(state, queried(state)),
);

function notesPassed(state: AppState, entries: Entries): Entries {
  const names = state.loaded?.names ?? [];
  return entries.filter((entry) =>
    isLetThrough(noteOf(state.notes, names[entry] ?? ""), state.page.notesFilter),
  );
}

/** How many visible entries the notes filter hides because they are marked as hidden. */
export const hiddenCount = remembered(
  (state) => [state.visible, state.notes, state.loaded] as const,
  (state) => {
    const names = state.loaded?.names ?? [];
    return state.visible.filter((entry) => noteOf(state.notes, names[entry] ?? "").hidden).length;
  },
);

/** The entries of passed() in the open group: the wall's content. */
export const within = remembered(
  (state) => [passed(state), state.opened] as const,
  (state) => {
    let entries = passed(state);
    for (const members of state.opened) entries = intersection(entries, members ?? noEntries);
    return entries;
  },
);

/** The entries of within() in the requested order. */
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

/** The names of ordered(). */
export const orderedNames = remembered(
  (state) => [ordered(state), state.loaded] as const,
  (state): readonly string[] => {
    const names = state.loaded?.names ?? [];
    return Array.from(ordered(state), (entry) => names[entry] ?? "");
  },
);

/** Whether the groups are those of the shown entries, with the requested grouping. */
export function areGroupsThere(state: AppState): boolean {
  const { groups: shown, page } = state;
  const { groups, by } = page.grouping;
  return shown !== null && shown.ask.groups === groups && shown.ask.by === by && isSame(shown.of, within(state));
}

function isSame(a: Entries, b: Entries): boolean {
  return a === b || (a.length === b.length && a.every((entry, i) => entry === b[i]));
}

export interface ChipCounts {
  /** Matches of the query alone; null: not answered yet. */
  readonly alone: number | null;
  /** Entries left if the query is applied together with the other chips, as IN and as NOT IN. */
  readonly asIn: number | null;
  readonly asNot: number | null;
}

/** Counts for a text that isn't applied yet, or for chip `id`, which is then not counted among the others. */
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

/** All chips that are on, as one query; "" if there are none. */
export function wholeQuery(chips: readonly Chip[]): string {
  return joined(signedQueries(chips));
}

/** The archive's present summary if it still contains this run; else the summary from when it was read. */
export function archiveShown(state: AppState): ArchiveSummary | null {
  const { gallery, loaded } = state;
  if (loaded === null) return null;
  if (replacing(state) !== null) return { ...loaded.archive, is_live: false, live_words: "" };
  return gallery?.archives.find(({ id }) => id === loaded.id) ?? null;
}

/** The archive that replaced the shown one with another run; null: none. */
export function replacing({ gallery, loaded }: AppState): ArchiveSummary | null {
  const archive = gallery?.archives.find(({ id }) => id === loaded?.id);
  // The run is unknown while an archive is first read after a server's start.
  const isOther = archive !== undefined && archive.run !== "" && archive.run !== loaded?.run;
  return isOther ? archive : null;
}

/** Number of animations that wait to be shown. */
export function offeredCount(state: AppState): number {
  return Math.max(0, (state.loaded?.names.length ?? 0) - state.visible.length);
}

/** What keys and buttons act on: the selection, else the focused animation. */
export function actedOn(state: AppState, focused: string | null): readonly string[] {
  if (state.selection.names.length > 0) return state.selection.names;
  return focused === null ? [] : [focused];
}
