// A history of steps for undo, each with the state before and after. Pure.

export interface UndoStep<Snapshot> {
  /** Description for people, such as "hidden: 3 animations". */
  readonly words: string;
  readonly before: Snapshot;
  readonly after: Snapshot;
}

export interface History<Snapshot> {
  readonly done: readonly UndoStep<Snapshot>[];
  readonly undone: readonly UndoStep<Snapshot>[];
}

/** A step to undo or redo, and the history after that; null: there is no step. */
export type Found<Snapshot> = { step: UndoStep<Snapshot>; history: History<Snapshot> } | null;

/** Maximum number of steps; the oldest are dropped. */
export const undoStepsMax = 200;

export function withStep<Snapshot>(history: History<Snapshot>, step: UndoStep<Snapshot>): History<Snapshot> {
  return { done: [...history.done, step].slice(-undoStepsMax), undone: [] };
}

/** Finds the step whose `before` must be restored. */
export function undo<Snapshot>(history: History<Snapshot>): Found<Snapshot> {
  const step = history.done.at(-1);
  if (step === undefined) return null;
  return { step, history: { done: history.done.slice(0, -1), undone: [...history.undone, step] } };
}

/** Finds the step whose `after` must be restored. */
export function redo<Snapshot>(history: History<Snapshot>): Found<Snapshot> {
  const step = history.undone.at(-1);
  if (step === undefined) return null;
  return { step, history: { done: [...history.done, step], undone: history.undone.slice(0, -1) } };
}
