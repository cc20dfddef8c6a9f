// Sets of entries (rows of an archive's table) as ascending Uint32Arrays.

export type Entries = Uint32Array;

export function allEntries(count: number): Entries {
  const all = new Uint32Array(count);
  for (let i = 0; i < count; i++) all[i] = i;
  return all;
}

/** Entries in both sets. */
export function intersection(a: Entries, b: Entries): Entries {
  const inB = new Set(b);
  return a.filter((entry) => inB.has(entry));
}

/** Entries of `a` that are not in `b`. */
export function difference(a: Entries, b: Entries): Entries {
  const inB = new Set(b);
  return a.filter((entry) => !inB.has(entry));
}

export function ascending(entries: Iterable<number>): Entries {
  return Uint32Array.from(entries).sort();
}
