// Plausibility in words: how an animation's log_prior compares with blind throws.
import { firstPast } from "../motion/bisection";

/** Percentage of blind throws that are less likely; null if unknown. */
export function throwsBelow(logPrior: number, blindThrows: readonly number[]): number | null {
  if (blindThrows.length === 0 || !Number.isFinite(logPrior)) return null;
  const below = firstPast(blindThrows.length, (i) => blindThrows[i]! >= logPrior);
  const share = (100 * below) / blindThrows.length;
  // 0 and 100 percent are reserved for exactly none and all.
  if (below === 0 || below === blindThrows.length) return share;
  return Math.min(99, Math.max(1, Math.round(share)));
}

export function plausibilityWords(logPrior: number, blindThrows: readonly number[]): string {
  const below = throwsBelow(logPrior, blindThrows);
  if (below === null) return "";
  if (below === 0) return "less likely than every blind throw";
  if (below === 100) return "more likely than every blind throw";
  return `more likely than ${below} of 100 blind throws`;
}

/** P(a chi-square variable of `count` degrees is at least `squares`): a series of the incomplete gamma function. */
export function chiSquareTail(squares: number, count: number): number {
  const half = squares / 2;
  // The series' first term: half^(count/2) e^-half / gamma(count/2 + 1).
  let log = -half + (count % 2 === 0 ? 0 : Math.log(2 * Math.sqrt(half / Math.PI)));
  for (let a = count % 2 === 0 ? 1 : 1.5; a <= count / 2; ++a) log += Math.log(half / a);
  if (log < -700) return squares > count ? 0 : 1;
  let term = Math.exp(log);
  let below = 0;
  for (let a = count / 2 + 1; term > 1e-12 || a <= half; ++a) {
    below += term;
    term *= half / a;
  }
  return Math.max(0, 1 - below);
}

/** Words for `count` standard normals with this sum of squares: how ordinary they are together. */
export function ordinaryWords(squares: number, count: number): string {
  if (!(count > 0) || !Number.isFinite(squares)) return "";
  return `random values as ordinary as in ${Math.round(100 * chiSquareTail(squares, count))} of 100 blind throws`;
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
