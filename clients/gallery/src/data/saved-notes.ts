// Stars and notes of a saved gallery. The gallery's files are read-only, so the browser stores the notes.
// Without storage, notes last until the page closes.

import { noteOf, patched } from "./note-patch";
import { isObject } from "./packed";
import { type AnimationName, type KeptNote, nameToday, type NotePatch } from "./types";

type OfRun = Record<AnimationName, KeptNote>;

const PREFIX = "sleight-notes.";

export class SavedNotes {
  private readonly runs = new Map<string, OfRun>();
  /** null: no storage is available. */
  private storage: Storage | null;

  constructor(storage: () => Storage) {
    this.storage = usable(storage);
  }

  /** Whether notes last longer than the page. */
  get areKept(): boolean {
    return this.storage !== null;
  }

  ofRun(run: string): Readonly<OfRun> {
    let notes = this.runs.get(run);
    if (notes === undefined) {
      notes = this.read(run);
      this.runs.set(run, notes);
    }
    return notes;
  }

  change(run: string, patches: Readonly<Record<AnimationName, NotePatch>>): OfRun {
    // Merges notes from another page with the same gallery.
    const notes = { ...this.ofRun(run), ...this.read(run) };
    const changed = 1 + Object.values(notes).reduce((most, one) => Math.max(most, one.changed), 0);
    const kept = Object.fromEntries(Object.entries(patches).map(([name, patch]) =>
      [name, { ...patched(noteOf(notes, name), patch), changed }]));
    const now = { ...notes, ...kept };
    this.runs.set(run, now);
    try {
      this.storage?.setItem(PREFIX + run, JSON.stringify(now));
    } catch {
      // The storage is full or was disabled: from now on, notes are lost when the page closes.
      this.storage = null;
    }
    return kept;
  }

  private read(run: string): OfRun {
    try {
      const all: unknown = JSON.parse(this.storage?.getItem(PREFIX + run) ?? "{}");
      if (!isObject(all)) return {};
      return Object.fromEntries(Object.entries(all)
        .filter((entry): entry is [string, KeptNote] => isNote(entry[1]))
        .map(([name, note]) => [nameToday(name), note]));
    } catch {
      return {};
    }
  }
}

/** Browsers throw at the first access if a page may not use storage. */
function usable(storage: () => Storage): Storage | null {
  try {
    const found = storage();
    found.setItem(PREFIX, "{}");
    found.removeItem(PREFIX);
    return found;
  } catch {
    return null;
  }
}

function isNote(value: unknown): value is KeptNote {
  return isObject(value) && typeof value["star"] === "boolean" && typeof value["hidden"] === "boolean" &&
    typeof value["note"] === "string" && typeof value["changed"] === "number" &&
    Array.isArray(value["tags"]) && value["tags"].every((tag) => typeof tag === "string");
}
