// What can be undone: steps that each know the state before and after. Pure.

export interface UndoStep<Snapshot> {
  /** What was done, for people: "hidden: 3 animations". */
  readonly words: string;
  readonly before: Snapshot;
  readonly after: Snapshot;
}

export interface History<Snapshot> {
  readonly done: readonly UndoStep<Snapshot>[];
  readonly undone: readonly UndoStep<Snapshot>[];
}

/** Steps behind which the oldest are forgotten. */
export const undoStepsMax = 200;

export function withStep<Snapshot>(history: History<Snapshot>, step: UndoStep<Snapshot>): History<Snapshot> {
  return { done: [...history.done, step].slice(-undoStepsMax), undone: [] };
}

/** The step whose `before` is to be put back, and the history then; nothing where none is left. */
export function undo<Snapshot>(
  history: History<Snapshot>,
): { step: UndoStep<Snapshot>; history: History<Snapshot> } | null {
  const step = history.done.at(-1);
  if (step === undefined) return null;
  return { step, history: { done: history.done.slice(0, -1), undone: [...history.undone, step] } };
}

/** The step whose `after` is to be put back. */
export function redo<Snapshot>(
  history: History<Snapshot>,
): { step: UndoStep<Snapshot>; history: History<Snapshot> } | null {
  const step = history.undone.at(-1);
  if (step === undefined) return null;
  return { step, history: { done: [...history.done, step], undone: history.undone.slice(0, -1) } };
}
