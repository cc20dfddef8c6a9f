// Changes to notes, recorded as patches so that other people's changes aren't overwritten. Pure functions.
import type { Note, NotePatch } from "./types";

export type NotesByName = Readonly<Record<string, Note>>;

export const emptyNote: Note = { star: false, hidden: false, tags: [], note: "" };

export function noteOf(notes: NotesByName, name: string): Note {
  return Object.hasOwn(notes, name) ? (notes[name] ?? emptyNote) : emptyNote;
}

export function patched({ star, hidden, tags, note }: Note, patch: NotePatch): Note {
  const left = tags.filter((tag) => !patch.tags_off?.includes(tag));
  const more = (patch.tags_on ?? []).filter((tag) => !left.includes(tag));
  return {
    star: patch.star ?? star,
    hidden: patch.hidden ?? hidden,
    tags: [...left, ...more],
    note: patch.note ?? note,
  };
}

export function patchBetween(before: Note, after: Note): NotePatch {
  const on = after.tags.filter((tag) => !before.tags.includes(tag));
  const off = before.tags.filter((tag) => !after.tags.includes(tag));
  return {
    ...(before.star === after.star ? {} : { star: after.star }),
    ...(before.hidden === after.hidden ? {} : { hidden: after.hidden }),
    ...(before.note === after.note ? {} : { note: after.note }),
    ...(on.length === 0 ? {} : { tags_on: on }),
    ...(off.length === 0 ? {} : { tags_off: off }),
  };
}

/** The patch with the effect of `first`, then `then`. */
export function joined(first: NotePatch, then: NotePatch): NotePatch {
  const without = (tags: readonly string[] = [], out: readonly string[] = []): string[] =>
    tags.filter((tag) => !out.includes(tag));
  const on = [...new Set([...without(first.tags_on, then.tags_off), ...(then.tags_on ?? [])])];
  const off = [...new Set([...without(first.tags_off, then.tags_on), ...(then.tags_off ?? [])])];
  return {
    ...first,
    ...then,
    ...(on.length > 0 || first.tags_on !== undefined ? { tags_on: on } : {}),
    ...(off.length > 0 || first.tags_off !== undefined ? { tags_off: off } : {}),
  };
}
