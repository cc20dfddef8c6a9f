// A person's actions on the page, except notes: views, groups, chips, selection, player.
import { noEntries, type AppState, type ShownGroup } from "./app-state";
import { orderedNames, wholeQuery } from "./derived";
import { pageOf } from "./link";
import type { NoteKeeping } from "./note-keeping";
import type { Chip, Page, View } from "./page";
import { comparedMax, extended, nothingSelected, toggled } from "./selection";
import { say } from "./messages";
import { asKept } from "./sorting";
import type { Store } from "./store";

export class PageActions {
  private nextChip = 1;

  constructor(
    private readonly store: Store<AppState>,
    private readonly keeping: NoteKeeping,
    /** Called when the page switches to another run. */
    private readonly lookAgain: () => void,
  ) {}

  /** Sets the page's state from a link. */
  applyLink(link: string): void {
    const before = this.store.state.page;
    const page = pageOf(link);
    this.nextChip = Math.max(this.nextChip, page.chips.length + 1);
    const run = page.run === "" ? before.run : page.run;
    const isSameRun = run === before.run && page.archive === before.archive;
    this.store.set({
      page: { ...page, run },
      selection: { names: page.selected, anchor: page.selected.at(-1) ?? null },
      opened: page.path.map((step, i) => {
        const old = before.path[i];
        const stays = isSameRun && JSON.stringify(step) === JSON.stringify(old);
        return stays ? (this.store.state.opened[i] ?? null) : null;
      }),
    });
    if (!isSameRun) this.lookAgain();
  }

  change(parts: Partial<Page>): void {
    this.store.set({ page: { ...this.store.state.page, ...parts } });
  }

  showArchive(run: string, archive: string): void {
    const { page } = this.store.state;
    if (run === page.run && archive === page.archive) return;
    this.store.set({ selection: nothingSelected, opened: [], groups: null, distances: null });
    const ofOther = { path: [], playing: [], timeS: null, camera: null, sort: asKept, plot: "" };
    this.change({ run, archive, ...ofOther });
    this.lookAgain();
  }

  showView(view: View): void {
    this.change({ view });
  }

  // Groups

  openGroup(group: ShownGroup): void {
    const { page, loaded, opened } = this.store.state;
    const representative = loaded?.names[group.representative];
    if (representative === undefined) return;
    const step = { ...page.grouping, representative, query: wholeQuery(page.chips) };
    this.store.set({ opened: [...opened, group.members] });
    this.change({ path: [...page.path, step], view: "list" });
  }

  /** Closes open groups until `depth` remain. */
  closeTo(depth: number): void {
    this.store.set({ opened: this.store.state.opened.slice(0, depth) });
    this.change({ path: this.store.state.page.path.slice(0, depth), view: "groups" });
  }

  // Queries

  addChip(text: string, isNot: boolean): void {
    const chip: Chip = { id: this.nextChip, text, isNot, isOn: true };
    this.nextChip += 1;
    this.keeping.setChips([...this.store.state.page.chips, chip], `${isNot ? "removed" : "kept"} matches of: ${text}`);
  }

  changeChip(id: number, parts: Partial<Chip>, words: string): void {
    const chips = this.store.state.page.chips.map((chip) => (chip.id === id ? { ...chip, ...parts } : chip));
    this.keeping.setChips(chips, words);
  }

  removeChip(id: number): void {
    const { chips } = this.store.state.page;
    const gone = chips.find((chip) => chip.id === id);
    this.keeping.setChips(
      chips.filter((chip) => chip !== gone),
      `deleted query: ${gone?.text ?? ""}`,
    );
  }

  // Selection

  select(name: string, how: "toggle" | "extend"): void {
    const { state } = this.store;
    const { selection } = state;
    this.store.set({
      selection: how === "toggle" ? toggled(selection, name) : extended(selection, name, orderedNames(state)),
    });
  }

  selectAll(): void {
    const names = orderedNames(this.store.state);
    this.store.set({ selection: { names, anchor: names[0] ?? null } });
  }

  selectNone(): void {
    this.store.set({ selection: nothingSelected });
  }

  sortByLikeness(to: readonly string[], isUnlike: boolean): void {
    if (to.length === 0) {
      say(this.store, "Select animations first: click a card, or press Space on it.");
      return;
    }
    // Similar animations may be in other groups, so the whole list is sorted.
    this.store.set({ opened: [] });
    this.change({ sort: { by: "alike", to: [...to], isUnlike }, view: "list", path: [] });
  }

  // Player

  play(names: readonly string[]): void {
    if (names.length > comparedMax)
      say(
        this.store,
        `Comparing only the first ${comparedMax} of ${names.length} animations, which is the maximum.`,
      );
    this.change({ playing: names.slice(0, comparedMax), timeS: null });
  }

  closePlayer(): void {
    this.store.set({ drawing: { box: false, time: false }, drawnBox: null, drawnRange: null });
    this.change({ playing: [], timeS: null });
  }
}

export function initialState(page: Page): AppState {
  return {
    page,
    selection: { names: page.selected, anchor: page.selected.at(-1) ?? null },
    gallery: null,
    source: "here",
    loaded: null,
    loadFailure: "",
    visible: noEntries,
    asOf: "",
    isBeginning: false,
    answers: new Map(),
    draft: "",
    built: "",
    notes: {},
    notesWords: "",
    hasNoPictures: false,
    history: { done: [], undone: [] },
    groups: null,
    groupsFailure: "",
    opened: page.path.map(() => null),
    distances: null,
    message: { words: "", number: 0 },
    drawing: { box: false, time: false },
    drawnBox: null,
    drawnRange: null,
  };
}
