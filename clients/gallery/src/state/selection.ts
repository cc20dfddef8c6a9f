// The selected animations, by name within the archive. Pure: functions return a new selection.

export interface Selection {
  readonly names: readonly string[];
  /** Start of a range that Shift extends. */
  readonly anchor: string | null;
}

export const nothingSelected: Selection = { names: [], anchor: null };

/** Maximum number of animations side by side in the player. */
export const comparedMax = 9;

export function isSelected(selection: Selection, name: string): boolean {
  return selection.names.includes(name);
}

/** Click or Space: toggles the animation; others stay. */
export function toggled(selection: Selection, name: string): Selection {
  const names = isSelected(selection, name)
    ? selection.names.filter((other) => other !== name)
    : [...selection.names, name];
  return { names, anchor: name };
}

/** Shift: adds all animations from the anchor to `name`, in the displayed order. */
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
