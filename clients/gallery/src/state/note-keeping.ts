// Changes notes and chips with undo, and saves notes through the source. Notes that cannot be saved yet wait
// in the page and are sent again; a message reports this.
import { joined, noteOf, patchBetween, patched, type NotesByName } from "../data/note-patch";
import { SourceError, type GallerySource } from "../data/source";
import type { Note, NotePatch } from "../data/types";
import type { AppState, Undoable } from "./app-state";
import { say, sentenceOf } from "./messages";
import { allToggled, notKept } from "./notes";
import type { Chip } from "./page";
import { Latest, type Store } from "./store";
import { type Found, redo, undo, withStep } from "./undo";

type Patches = Readonly<Record<string, NotePatch>>;

/** Maximum patches per request. */
const patchesMax = 2000;
/** Browsers send at most 64 kB for a page that closes. */
const leavingBytesMax = 60_000;
/** A save that takes longer is reported. */
const lateMs = 2000;
const noAnswer = "the gallery's server doesn't answer.";

export class NoteKeeping {
  private readonly latest = new Latest();
  /** Patches that aren't saved yet, by run and name. */
  private readonly waiting = new Map<string, Map<string, NotePatch>>();
  /** Counts local changes and completed saves. */
  private changes = 0;
  private isSending = false;
  private atOnce = patchesMax;

  constructor(
    private readonly store: Store<AppState>,
    private readonly source: GallerySource,
  ) {}

  /** Reads the notes of each run that is shown, and again when a person returns to the page. `window`
   *  reports this return and the page's closing; waiting changes are sent when it closes. If they cannot be
   *  sent then, the browser asks the person before it leaves the page. */
  start(window: EventTarget): void {
    const again = (): void => {
      const { loaded } = this.store.state;
      if (loaded !== null) void this.read(loaded.run);
    };
    const ask = (event: Event): void => {
      const bytes = JSON.stringify([...this.waiting].map(([, ofRun]) => [...ofRun])).length;
      const isTooMuch = bytes > leavingBytesMax;
      if (this.isWaiting() && (isTooMuch || this.store.state.notesWords !== "")) event.preventDefault();
    };
    window.addEventListener("focus", again);
    window.addEventListener("pagehide", () => this.sendAtOnce());
    window.addEventListener("beforeunload", ask);
    this.store.subscribe((state, before) => {
      const isOther = state.loaded?.run !== before.loaded?.run;
      const isBack = state.source === "here" && before.source !== "here";
      if (isOther || isBack) again();
    });
  }

  private async read(run: string): Promise<void> {
    const isWanted = this.latest.begin();
    const { changes } = this;
    try {
      const all = await this.source.notes();
      if (!isWanted()) return;
      // The answer may lack changes that were saved meanwhile.
      if (changes !== this.changes) return await this.read(run);
      const notes: Record<string, Note> = { ...all.notes[run] };
      for (const [name, patch] of this.waiting.get(run) ?? []) notes[name] = patched(noteOf(notes, name), patch);
      this.store.set({ notes, notesWords: "" });
      await this.send();
    } catch (error) {
      if (isWanted()) this.store.set({ notesWords: notKept(sentenceOf(error)) });
    }
  }

  toggle(names: readonly string[], key: "star" | "hidden"): void {
    if (names.length === 0) return;
    const changed = allToggled(this.store.state.notes, names, key);
    const isOn = Object.values(changed)[0]?.[key] ?? false;
    const verb = key === "star" ? (isOn ? "starred" : "unstarred") : isOn ? "hidden" : "unhidden";
    this.change(changed, `${verb}: ${named(names)}`);
  }

  /** `before`: the note that the person saw; `run`: the run of the animation then. */
  edit(run: string, name: string, before: Note, part: Partial<Note>): void {
    const after = { ...before, ...part };
    const what = part.note === undefined ? "changed tags" : "changed note";
    this.step(run, { [name]: patchBetween(after, before) }, { [name]: patchBetween(before, after) },
      `${what} of ${name}`);
  }

  /** Adds the tag to all animations; if all have the tag, removes it from all. */
  toggleTag(names: readonly string[], tag: string): void {
    const { notes } = this.store.state;
    const isOn = !names.every((name) => noteOf(notes, name).tags.includes(tag));
    const changed: Record<string, Note> = {};
    for (const name of names)
      changed[name] = patched(noteOf(notes, name), isOn ? { tags_on: [tag] } : { tags_off: [tag] });
    this.change(changed, `tag “${tag}” ${isOn ? "added" : "removed"}: ${named(names)}`);
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
    this.restore(undo(this.store.state.history), "before", "Undone", "Nothing to undo.");
  }

  redo(): void {
    this.restore(redo(this.store.state.history), "after", "Redone", "Nothing to redo.");
  }

  private restore(found: Found<Undoable>, state: "before" | "after", done: string, nothing: string): void {
    if (found !== null) {
      this.store.set({ history: found.history });
      this.put(found.step[state]);
    }
    say(this.store, found === null ? nothing : `${done}: ${found.step.words}.`);
  }

  private change(changed: NotesByName, words: string): void {
    const { notes, loaded } = this.store.state;
    if (loaded === null) return;
    const between = (from: NotesByName, to: NotesByName): Patches =>
      Object.fromEntries(Object.keys(changed).map((name) => [
        name, patchBetween(noteOf(from, name), noteOf(to, name)),
      ]));
    this.step(loaded.run, between(changed, notes), between(notes, changed), words);
  }

  private step(run: string, before: Patches, after: Patches, words: string): void {
    this.store.set({
      history: withStep(this.store.state.history, {
        words,
        before: { kind: "notes", run, notes: before },
        after: { kind: "notes", run, notes: after },
      }),
    });
    this.putNotes(run, after);
    say(this.store, `${words[0]?.toUpperCase() ?? ""}${words.slice(1)}. Press Ctrl+Z to undo.`);
  }

  private put(undoable: Undoable): void {
    if (undoable.kind === "notes") this.putNotes(undoable.run, undoable.notes);
    else this.store.set({ page: { ...this.store.state.page, chips: undoable.chips } });
  }

  private putNotes(run: string, changed: Patches): void {
    this.changes += 1;
    const ofRun = this.waiting.get(run) ?? new Map<string, NotePatch>();
    this.waiting.set(run, ofRun);
    const notes: Record<string, Note> = { ...this.store.state.notes };
    for (const [name, patch] of Object.entries(changed)) {
      ofRun.set(name, joined(ofRun.get(name) ?? {}, patch));
      notes[name] = patched(noteOf(notes, name), patch);
    }
    if (run === this.store.state.loaded?.run) this.store.set({ notes });
    void this.send();
  }

  /** Saves all waiting patches. */
  private async send(): Promise<void> {
    if (this.isSending) return;
    this.isSending = true;
    let words = "";
    const late = setTimeout(() => this.store.set({ notesWords: notKept(noAnswer) }), lateMs);
    try {
      for (let next = this.nextWaiting(); next !== null; next = this.nextWaiting()) {
        const { run, patches } = next;
        const isAlone = Object.keys(patches).length === 1;
        const answer = await this.source.changeNotes(run, patches).catch((error: unknown) => {
          if (!(error instanceof SourceError) || error.kind !== "other") throw error;
          // The source has refused a patch permanently. Sending patches one by one finds this patch.
          if (isAlone) words = notKept(sentenceOf(error));
          return null;
        });
        if (answer !== null || isAlone) this.sent(run, patches);
        if (answer !== null) this.show(run, answer.notes, answer.words);
        else this.atOnce = 1;
      }
    } catch (error) {
      words = notKept(sentenceOf(error));
    } finally {
      clearTimeout(late);
      if (!this.isWaiting()) this.atOnce = patchesMax;
      this.isSending = false;
    }
    if (this.store.state.notesWords !== words) this.store.set({ notesWords: words });
  }

  /** Shows the notes as they were saved, except notes that were changed again meanwhile. */
  private show(run: string, kept: NotesByName, why: string): void {
    const { notes, loaded, gallery } = this.store.state;
    if (gallery !== null && gallery.notes.words !== why)
      this.store.set({ gallery: { ...gallery, notes: { writable: why === "", words: why } } });
    if (run !== loaded?.run) return;
    const settled = Object.entries(kept).filter(([name]) => !this.waiting.get(run)?.has(name));
    this.store.set({ notes: { ...notes, ...Object.fromEntries(settled) } });
  }

  /** Sends all waiting patches as the page closes, including patches in a request that the browser may have
   *  cut off. So a patch may arrive twice. If the page stays open, the patches wait for a regular answer. */
  private sendAtOnce(): void {
    for (const [run, ofRun] of this.waiting) {
      if (ofRun.size > 0)
        this.source.changeNotes(run, Object.fromEntries(ofRun), { outlivesPage: true }).catch(() => undefined);
    }
  }

  private isWaiting(): boolean {
    return this.nextWaiting() !== null;
  }

  /** Some waiting patches of one run. */
  private nextWaiting(): { run: string; patches: Patches } | null {
    for (const [run, ofRun] of this.waiting)
      if (ofRun.size > 0) return { run, patches: Object.fromEntries([...ofRun].slice(0, this.atOnce)) };
    return null;
  }

  /** Removes saved patches from the waiting ones, unless the note was changed again. */
  private sent(run: string, patches: Patches): void {
    this.changes += 1;
    const ofRun = this.waiting.get(run);
    for (const [name, patch] of Object.entries(patches)) if (ofRun?.get(name) === patch) ofRun.delete(name);
  }
}

function named(names: readonly string[]): string {
  return names.length <= 3 ? names.join(", ") : `${names.length} animations`;
}
