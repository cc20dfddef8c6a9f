// Plausibility in words: where an animation's log p stands among those of blind throws.

/** How many of 100 blind throws it is more likely than; nothing where that is not known. */
export function throwsBelow(logPrior: number, blindThrows: readonly number[]): number | null {
  if (blindThrows.length === 0 || !Number.isFinite(logPrior)) return null;
  let low = 0;
  let high = blindThrows.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((blindThrows[middle] ?? Infinity) < logPrior) low = middle + 1;
    else high = middle;
  }
  const share = (100 * low) / blindThrows.length;
  // "All" and "none" are said of all and none alone.
  if (low === 0) return 0;
  if (low === blindThrows.length) return 100;
  return Math.min(99, Math.max(1, Math.round(share)));
}

export function plausibilityWords(logPrior: number, blindThrows: readonly number[]): string {
  const below = throwsBelow(logPrior, blindThrows);
  if (below === null) return "";
  if (below === 0) return "less likely than every blind throw";
  if (below === 100) return "more likely than every blind throw";
  return `more likely than ${below} of 100 blind throws`;
}

export const plausibilityHelp =
  "Plausibility: the density p of this animation's random choices (log_prior), before the goal is " +
  "looked at, beside those of throws that were made without any goal. Likelier than many blind " +
  "throws: it looks as if chance alone had made it.";

export const scoreHelp =
  "Score (log_constraint): how well the goal is met, as the run's constraint counts it; the higher, " +
  "the better. 0 is a full match where the constraint is a distance to the goal.";

export const proportionHelp =
  "Not in proportion: these animations were found by search, or kept because they differ. How often " +
  "one kind is among them says nothing about its probability.";

export const shareHelp =
  "Share: how much of all satisfied draws looks like this, with its standard error. The number kept is " +
  "no such thing: what is kept is kept because it differs.";
