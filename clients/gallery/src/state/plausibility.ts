// Plausibility in words: how an animation's log_prior compares with blind throws.

/** Percentage of blind throws that are less likely; null if unknown. */
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
  // 0 and 100 percent are reserved for exactly none and all.
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
  "Plausibility compares an animation's log_prior with the log_prior of blind throws, which have no goal. " +
  "An animation looks as if it happened by chance if it is more likely than many blind throws.";

export const scoreHelp =
  "Score (log_constraint): how well the animation meets the run's constraint; higher is better. " +
  "If the constraint is a distance to the goal, 0 is a perfect match.";

export const proportionHelp =
  "Not in proportion: these animations were found by search, or kept because they differ from each other. " +
  "The number of animations in a group doesn't show how probable the group is.";

export const shareHelp =
  "Share: fraction of all satisfying draws that look like this group, with standard error. " +
  "Kept animations have no shares, because an archive keeps only distinct animations.";
