// Changes notes and chips so that they can be undone, and has the source keep the notes. Where they
// can't be kept they last as long as the page, and one sentence says so.
import type { GallerySource } from "../data/source";
import type { Note } from "../data/types";
import type { AppState, Undoable } from "./app-state";
import { say, sentenceOf } from "./messages";
import { allToggled, noteOf, notKept, type NotesByName } from "./notes";
import type { Chip } from "./page";
import { Latest, type Store } from "./store";
import { redo, undo, withStep } from "./undo";

export class NoteKeeping {
  private readonly latest = new Latest();

  constructor(
    private readonly store: Store<AppState>,
    private readonly source: GallerySource,
  ) {}

  /** Reads the notes of each run that comes to be shown. */
  start(): () => void {
    return this.store.subscribe((state, before) => {
      const isOther = state.loaded?.run !== before.loaded?.run;
      const isBack = state.source === "here" && before.source === "away";
      if (state.loaded !== null && (isOther || isBack)) void this.read(state.loaded.run);
    });
  }

  private async read(run: string): Promise<void> {
    const isWanted = this.latest.begin();
    try {
      const all = await this.source.notes();
      if (!isWanted()) return;
      this.store.set({ notes: all.notes[run] ?? {}, notesWords: "" });
    } catch (error) {
      if (isWanted()) this.store.set({ notesWords: notKept(sentenceOf(error)) });
    }
  }

  toggle(names: readonly string[], key: "star" | "hidden"): void {
    if (names.length === 0) return;
    const changed = allToggled(this.store.state.notes, names, key);
    const isOn = Object.values(changed)[0]?.[key] ?? false;
    const verb = key === "star" ? (isOn ? "starred" : "star taken off") : isOn ? "hidden" : "shown again";
    this.change(changed, `${verb}: ${named(names)}`);
  }

  edit(name: string, note: Partial<Note>): void {
    this.change({ [name]: { ...noteOf(this.store.state.notes, name), ...note } }, `note of ${name}`);
  }

  /** Gives all of them the tag, or takes it from all where all have it. */
  toggleTag(names: readonly string[], tag: string): void {
    const { notes } = this.store.state;
    const isOn = !names.every((name) => noteOf(notes, name).tags.includes(tag));
    const changed: Record<string, Note> = {};
    for (const name of names) {
      const note = noteOf(notes, name);
      const others = note.tags.filter((other) => other !== tag);
      changed[name] = { ...note, tags: isOn ? [...others, tag] : others };
    }
    this.change(changed, `tag “${tag}” ${isOn ? "on" : "off"}: ${named(names)}`);
  }

  setChips(chips: readonly Chip[], words: string): void {
    const { history, page } = this.store.state;
    const before: Undoable = { kind: "chips", chips: page.chips };
    this.store.set({
      page: { ...page, chips },
      history: withStep(history, { words, before, after: { kind: "chips", chips } }),
    });
  }

  undo(): void {
    const last = undo(this.store.state.history);
    if (last === null) {
      say(this.store, "There is nothing to undo.");
      return;
    }
    this.store.set({ history: last.history });
    this.put(last.step.before);
    say(this.store, `Undone — ${last.step.words}.`);
  }

  redo(): void {
    const next = redo(this.store.state.history);
    if (next === null) {
      say(this.store, "There is nothing to redo.");
      return;
    }
    this.store.set({ history: next.history });
    this.put(next.step.after);
    say(this.store, `Done again — ${next.step.words}.`);
  }

  private change(changed: Record<string, Note>, words: string): void {
    const { notes, history } = this.store.state;
    const before: Record<string, Note> = {};
    for (const name of Object.keys(changed)) before[name] = noteOf(notes, name);
    this.store.set({
      history: withStep(history, {
        words,
        before: { kind: "notes", notes: before },
        after: { kind: "notes", notes: changed },
      }),
    });
    this.putNotes(changed);
    say(this.store, `${words[0]?.toUpperCase() ?? ""}${words.slice(1)}. Ctrl+Z undoes it.`);
  }

  private put(undoable: Undoable): void {
    if (undoable.kind === "notes") this.putNotes(undoable.notes);
    else this.store.set({ page: { ...this.store.state.page, chips: undoable.chips } });
  }

  private putNotes(changed: NotesByName): void {
    const { loaded, notes } = this.store.state;
    this.store.set({ notes: { ...notes, ...changed } });
    if (loaded === null) return;
    void this.keep(loaded.run, changed);
  }

  private async keep(run: string, changed: NotesByName): Promise<void> {
    try {
      // One after another: what fails once would fail as often as there are names.
      for (const [name, note] of Object.entries(changed)) {
        const { star, hidden, tags, note: text } = note;
        await this.source.setNote(run, name, { star, hidden, tags, note: text });
      }
      if (this.store.state.notesWords !== "") this.store.set({ notesWords: "" });
    } catch (error) {
      this.store.set({ notesWords: notKept(sentenceOf(error)) });
    }
  }
}

function named(names: readonly string[]): string {
  return names.length <= 3 ? names.join(", ") : `${names.length} animations`;
}
