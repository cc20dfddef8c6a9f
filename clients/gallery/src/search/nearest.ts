// Suggests a known name for a mistyped name, as common/request/nearest.cpp does, on bytes (bytes.ts).

/** Longer texts match no name. */
const LENGTH_MAX = 64;
/** Minimum length of a prefix: shorter ones match too many names. */
const FRONT_MIN = 3;

/** Number of edits that turn `a` into `b`: insertions, deletions, replacements, swaps of neighbours. */
export function editDistance(a: string, b: string): number {
  let before2: number[] = [];
  let before: number[] = [];
  let now = Array.from({ length: b.length + 1 }, (_, j) => j);
  for (let i = 1; i <= a.length; ++i) {
    [before2, before, now] = [before, now, [i]];
    for (let j = 1; j <= b.length; ++j) {
      const replaced = before[j - 1]! + (a[i - 1] === b[j - 1] ? 0 : 1);
      now[j] = Math.min(before[j]! + 1, now[j - 1]! + 1, replaced);
      if (i > 1 && j > 1 && a[i - 1] === b[j - 2] && a[i - 2] === b[j - 1])
        now[j] = Math.min(now[j]!, before2[j - 2]! + 1);
    }
  }
  return now[b.length]!;
}

/** The known name that `written` most likely means; of equally near names the earlier one. */
export function nearest(written: string, known: readonly string[]): string | null {
  if (written.length > LENGTH_MAX) return null;
  const wanted = folded(written);
  let best: string | null = null;
  let least = 0;
  for (const name of known) {
    const edits = editDistance(wanted, folded(name));
    // A name with every character replaced isn't a typing error.
    if (edits > 1 + Math.floor(name.length / 4) || edits >= Math.min(wanted.length, name.length)) continue;
    if (best === null || edits < least) [best, least] = [name, edits];
  }
  return best ?? known.find((name) => isFrontOf(wanted, name) || isFrontOf(name, wanted)) ?? null;
}

function folded(name: string): string {
  return name.replace(/[A-Z]/g, (sign) => sign.toLowerCase()).replaceAll("-", "_");
}

function isFrontOf(front: string, whole: string): boolean {
  return front.length >= FRONT_MIN && whole.startsWith(front) && whole[front.length] === "_";
}
