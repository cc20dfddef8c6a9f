// Which animations are chosen, by their names within the archive. Pure: each function gives a new
// selection.

export interface Selection {
  readonly names: readonly string[];
  /** Where a range that is made with shift begins. */
  readonly anchor: string | null;
}

export const nothingSelected: Selection = { names: [], anchor: null };

/** As many as stand beside one another in the player. */
export const comparedMax = 9;

export function isSelected(selection: Selection, name: string): boolean {
  return selection.names.includes(name);
}

/** A plain click or space: in if it was out, out if it was in; others stay. */
export function toggled(selection: Selection, name: string): Selection {
  const names = isSelected(selection, name)
    ? selection.names.filter((other) => other !== name)
    : [...selection.names, name];
  return { names, anchor: name };
}

export function only(name: string): Selection {
  return { names: [name], anchor: name };
}

/** Shift: all from the anchor to here in the order that is shown, added to what was chosen. */
export function extended(selection: Selection, name: string, shown: readonly string[]): Selection {
  const to = shown.indexOf(name);
  const from = selection.anchor === null ? -1 : shown.indexOf(selection.anchor);
  if (to < 0) return selection;
  if (from < 0) return toggled(selection, name);
  const [low, high] = from < to ? [from, to] : [to, from];
  const names = new Set(selection.names);
  for (const between of shown.slice(low, high + 1)) names.add(between);
  return { names: [...names], anchor: selection.anchor };
}

/** Those that still exist. */
export function kept(selection: Selection, exists: (name: string) => boolean): Selection {
  const names = selection.names.filter(exists);
  if (names.length === selection.names.length) return selection;
  return { names, anchor: selection.anchor !== null && exists(selection.anchor) ? selection.anchor : null };
}
