// Functions on a person's notes. Pure.
import { noteOf, type NotesByName } from "../data/note-patch";
import type { Note } from "../data/types";
import type { NotesFilter } from "./page";

export function isLetThrough(note: Note, filter: NotesFilter): boolean {
  if (filter.star && !note.star) return false;
  if (filter.tag !== "" && !note.tags.includes(filter.tag)) return false;
  return filter.hidden === "with" || note.hidden === (filter.hidden === "only");
}

/** All tags in use, most used first. */
export function tagsOf(notes: NotesByName): string[] {
  const counts = new Map<string, number>();
  for (const note of Object.values(notes))
    for (const tag of note.tags) counts.set(tag, (counts.get(tag) ?? 0) + 1);
  return [...counts].sort((a, b) => b[1] - a[1] || (a[0] < b[0] ? -1 : 1)).map(([tag]) => tag);
}

/** Splits "red, long throw" into distinct tags. */
export function tagsOfText(text: string): string[] {
  return [
    ...new Set(
      text
        .split(",")
        .map((tag) => tag.trim())
        .filter((tag) => tag !== ""),
    ),
  ];
}

/** Clears the key if all animations have it; else sets it for all. */
export function allToggled(
  notes: NotesByName,
  names: readonly string[],
  key: "star" | "hidden",
): Record<string, Note> {
  const isOn = !names.every((name) => noteOf(notes, name)[key]);
  const changed: Record<string, Note> = {};
  for (const name of names) changed[name] = { ...noteOf(notes, name), [key]: isOn };
  return changed;
}

export function notKept(why: string): string {
  return `Notes are not saved; this page keeps them while it is open. Reason: ${why || "the server cannot write them."}`;
}
