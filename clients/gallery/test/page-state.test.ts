// Goal: selection, undo, notes, sorting, sets of entries and texts work. Method: check small cases computed
// by hand, and compare sets with a slow method.
import assert from "node:assert/strict";
import { test } from "node:test";
import { allEntries, ascending, difference, intersection } from "../src/state/entry-sets";
import { exportLine, shellWord } from "../src/state/export-line";
import { noteOf } from "../src/data/note-patch";
import { allToggled, isLetThrough, tagsOf, tagsOfText } from "../src/state/notes";
import { noNotesFilter } from "../src/state/page";
import { chiSquareTail, ordinaryWords, plausibilityWords, throwsBelow } from "../src/state/plausibility";
import { extended, nothingSelected, toggled } from "../src/state/selection";
import { sortedByNumber, sortFromText, sortToText } from "../src/state/sorting";
import { Store } from "../src/state/store";
import { type History, redo, undo, undoStepsMax, withStep } from "../src/state/undo";

test("a click selects one card, and Shift with a click selects a range", () => {
  const shown = ["a", "b", "c", "d", "e"];
  let selection = toggled(nothingSelected, "b");
  selection = extended(selection, "d", shown);
  assert.deepEqual(selection.names, ["b", "c", "d"]);
  selection = extended(selection, "a", shown);
  assert.deepEqual([...selection.names].sort(), ["a", "b", "c", "d"]);
  selection = toggled(selection, "c");
  assert.ok(!selection.names.includes("c"));
  assert.deepEqual(extended(nothingSelected, "c", shown).names, ["c"]);
});

test("undo and redo restore states; after an undo, a new step discards the undone steps", () => {
  const empty: History<number> = { done: [], undone: [] };
  let history = empty;
  for (let i = 0; i < undoStepsMax + 5; i++)
    history = withStep(history, { words: String(i), before: i, after: i + 1 });
  assert.equal(history.done.length, undoStepsMax);
  const first = undo(history);
  assert.equal(first?.step.before, undoStepsMax + 4);
  const back = redo(first?.history ?? history);
  assert.equal(back?.step.after, undoStepsMax + 5);
  const other = withStep(first?.history ?? history, { words: "other", before: 0, after: 1 });
  assert.equal(redo(other), null);
  assert.equal(undo(empty), null);
});

test("the notes filter selects animations by their notes", () => {
  const notes = {
    a: { star: true, hidden: false, tags: ["x", "y"], note: "" },
    b: { star: false, hidden: true, tags: ["x"], note: "" },
  };
  assert.equal(isLetThrough(noteOf(notes, "b"), noNotesFilter), false);
  assert.equal(isLetThrough(noteOf(notes, "b"), { ...noNotesFilter, hidden: "only" }), true);
  assert.equal(isLetThrough(noteOf(notes, "c"), { ...noNotesFilter, star: true }), false);
  assert.equal(isLetThrough(noteOf(notes, "a"), { ...noNotesFilter, star: true, tag: "y" }), true);
  assert.equal(noteOf(notes, "constructor").star, false);
  assert.deepEqual(tagsOf(notes), ["x", "y"]);
  assert.deepEqual(tagsOfText(" red, long throw,, red "), ["red", "long throw"]);
  assert.equal(allToggled(notes, ["a", "b"], "star")["b"]?.star, true);
  assert.equal(allToggled(notes, ["a"], "star")["a"]?.star, false);
});

test("0 and 100 of 100 blind throws are never rounded values", () => {
  const throws = Array.from({ length: 1000 }, (_, i) => i);
  assert.equal(throwsBelow(-1, throws), 0);
  assert.equal(throwsBelow(0.5, throws), 1);
  assert.equal(throwsBelow(719.5, throws), 72);
  assert.equal(throwsBelow(998.5, throws), 99);
  assert.equal(throwsBelow(1000, throws), 100);
  assert.equal(throwsBelow(NaN, throws), null);
  assert.equal(plausibilityWords(5, []), "");
  assert.match(plausibilityWords(719.5, throws), /more likely.* 72 of 100 /);
});

test("chi-square tails are those of tables", () => {
  // Abramowitz and Stegun, table 26.8; for 2000 degrees, the median is 2000 - 2/3.
  for (const [squares, count, tail] of [
    [3.84146, 1, 0.05],
    [5.99146, 2, 0.05],
    [2.36597, 3, 0.5],
    [90.5312, 60, 0.006617],
    [1999.333, 2000, 0.5],
  ] as const)
    assert.ok(Math.abs(chiSquareTail(squares, count) - tail) < 1e-4, `${squares} ${count}`);
  assert.ok(chiSquareTail(5000, 2000) < 1e-9);
  assert.equal(chiSquareTail(1, 2000), 1);
  assert.match(ordinaryWords(2.36597, 3), / 50 of 100 /);
  assert.equal(ordinaryWords(NaN, NaN), "");
});

test("entries without a number are sorted last in either direction", () => {
  const column = [3, NaN, 1, 3, 2];
  assert.deepEqual([...sortedByNumber(allEntries(5), column, false)], [2, 4, 0, 3, 1]);
  assert.deepEqual([...sortedByNumber(allEntries(5), column, true)], [0, 3, 4, 2, 1]);
  for (const text of ["", "+log_prior", "-offsets[2]", "like:c0.1,find.2", "unlike:c0.1"])
    assert.equal(sortToText(sortFromText(text)), text);
});

test("set operations on entries agree with a slow method", () => {
  for (let seed = 1; seed < 200; seed++) {
    const some = (factor: number): Uint32Array =>
      allEntries(40).filter((entry) => (entry * factor * seed) % 7 < 3);
    const a = some(3);
    const b = some(5);
    assert.deepEqual(
      [...intersection(a, b)],
      [...a].filter((entry) => b.includes(entry)),
    );
    assert.deepEqual(
      [...difference(a, b)],
      [...a].filter((entry) => !b.includes(entry)),
    );
  }
  assert.deepEqual([...ascending([5, 1, 3])], [1, 3, 5]);
});

test("the export command is quoted for a shell", () => {
  assert.equal(exportLine("hi.h5", ["c0.250"], []), "sleight export hi.h5 --ids c0.250 -o c0.250.glb");
  assert.equal(
    exportLine("it's.h5", ["c0.1", "find.2"], []),
    `sleight export 'it'\\''s.h5' --ids c0.1 find.2 -o animations`,
  );
  assert.equal(
    exportLine("a.h5", [], [{ text: "x < 1", isNot: true }]),
    "sleight export a.h5 --select 'not (x < 1)' -o animations",
  );
  assert.equal(exportLine("a.h5", [], []), "sleight export a.h5 --all -o animations");
  assert.equal(shellWord("-rf"), "'-rf'");
});

test("simultaneous changes notify the store's listeners once", async () => {
  const store = new Store({ a: 1, b: 1 });
  const told: number[][] = [];
  const end = store.subscribe((state, before) => told.push([before.a, state.a, state.b]));
  store.set({ a: 2 });
  store.set({ b: 3 });
  await Promise.resolve();
  end();
  store.set({ a: 4 });
  await Promise.resolve();
  assert.deepEqual(told, [[1, 2, 3]]);
});
