// Sets of entries (rows of an archive's table) as ascending Uint32Arrays.

export type Entries = Uint32Array;

export function allEntries(count: number): Entries {
  const all = new Uint32Array(count);
  for (let i = 0; i < count; i++) all[i] = i;
  return all;
}

/** Entries in both sets. */
export function intersection(a: Entries, b: Entries): Entries {
  const both = new Uint32Array(Math.min(a.length, b.length));
  let count = 0;
  let i = 0;
  let k = 0;
  while (i < a.length && k < b.length) {
    const left = a[i] ?? 0;
    const right = b[k] ?? 0;
    if (left === right) {
      both[count] = left;
      count += 1;
    }
    if (left <= right) i += 1;
    if (right <= left) k += 1;
  }
  return both.slice(0, count);
}

/** Entries of `a` that are not in `b`. */
export function difference(a: Entries, b: Entries): Entries {
  const rest = new Uint32Array(a.length);
  let count = 0;
  let k = 0;
  for (const entry of a) {
    while (k < b.length && (b[k] ?? 0) < entry) k += 1;
    if (k < b.length && b[k] === entry) continue;
    rest[count] = entry;
    count += 1;
  }
  return rest.slice(0, count);
}

export function filtered(a: Entries, keep: (entry: number) => boolean): Entries {
  return a.filter(keep);
}

export function ascending(entries: Iterable<number>): Entries {
  return Uint32Array.from(entries).sort();
}
