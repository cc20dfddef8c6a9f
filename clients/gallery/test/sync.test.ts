import assert from "node:assert/strict";
import { test } from "node:test";
import { whereTheyPart } from "../src/motion/parting";
import { sharedRange, shiftOf } from "../src/motion/sync";
import { Clock } from "../src/view/clock";
import { recordingFrom, type Row } from "./recordings";

const G = -10;

/** Falls from 1.25 m at `start`, hits the ground half a second later, and rests at `end`. */
function fall(start: number, end: number, to: readonly [number, number, number] = [0, 0, 0]): Row[] {
  return [
    { start, p: [0, 0, 1.25], a: [0, 0, G] },
    { start: start + 0.5, cause: "hit", partner: 1, v: [to[0] / (end - start - 0.5), 0, 0], mode: "sliding" },
    { start: end, cause: "rest", mode: "resting", p: to },
  ];
}

test("aligned animations agree at shared time 0", () => {
  // Goal: each mode aligns the right events. Method: align two falls, one later and longer.
  const a = recordingFrom(fall(0.25, 2));
  const b = recordingFrom(fall(1, 4));
  assert.deepEqual([shiftOf(a, "start"), shiftOf(b, "start")], [0, 0]);
  assert.deepEqual([shiftOf(a, "contact"), shiftOf(b, "contact")], [0.75, 1.5]);
  assert.deepEqual([shiftOf(a, "end"), shiftOf(b, "end")], [2, 4]);
  assert.deepEqual(sharedRange([a, b], "start"), { from: 0, to: 4 });
  assert.deepEqual(sharedRange([a, b], "contact"), { from: -1.5, to: 2.5 });
  assert.deepEqual(sharedRange([a, b], "end"), { from: -4, to: 0 });
  assert.deepEqual(sharedRange([], "end"), { from: 0, to: 0 });
});

test("animations differ once their distance exceeds the tolerance", () => {
  // Goal: the time at which two animations start to differ equals the closed form. Method: after the hit, let
  // one body continue at 1 m/s and the other at 2 m/s.
  const rows = (speed: number): Row[] => [
    { p: [0, 0, 1.25], a: [0, 0, G] }, { start: 0.5, cause: "hit", v: [speed, 0, 0] },
    { start: 5, cause: "rest", mode: "resting", p: [4.5 * speed, 0, 0] },
  ];
  const a = { recording: recordingFrom(rows(1)), shift: 0 };
  const b = { recording: recordingFrom(rows(2)), shift: 0 };
  const t = whereTheyPart(a, b, 0.01);
  assert.ok(t !== null && Math.abs(t - 0.51) < 3e-5, `${t}`);
  assert.equal(whereTheyPart(b, a, 0.01), t);
  assert.equal(whereTheyPart(a, a, 1e-6), null);
});

test("a short difference between two animations is found", () => {
  // Goal: steps are short enough for the bodies' speeds. Method: after an hour without events, move one body
  // away by 5 mm and back within 4 ms.
  const still: Row[] = [{ mode: "resting" }, { start: 4000, mode: "resting" }];
  const jerk: Row[] = [
    { mode: "resting" }, { start: 3600, v: [2.5, 0, 0] },
    { start: 3600.002, v: [-2.5, 0, 0], p: [0.005, 0, 0] },
    { start: 3600.004, mode: "resting" }, { start: 4000, mode: "resting" },
  ];
  const of = (rows: Row[]) => ({ recording: recordingFrom(rows), shift: 0 });
  const t = whereTheyPart(of(still), of(jerk), 0.004);
  assert.ok(t !== null && Math.abs(t - 3600.0016) < 3e-5, `${t}`);
  assert.equal(whereTheyPart(of(still), of(jerk), 0.0051), null);
});

test("equal falls that are aligned at the contact never differ", () => {
  // Goal: shifts are respected, even if rounding makes them inexact. Method: start the same fall at odd
  // times.
  const a = recordingFrom(fall(0.1, 2.1));
  const b = recordingFrom(fall(0.7, 2.7));
  const by = (mode: "start" | "contact") => whereTheyPart(
    { recording: a, shift: shiftOf(a, mode) }, { recording: b, shift: shiftOf(b, mode) }, 1e-3);
  assert.equal(by("contact"), null);
  const apart = by("start");
  // One body falls 1 mm before the other enters: sqrt(2 * 1e-3 / 10) s after its start.
  assert.ok(apart !== null && Math.abs(apart - 0.1 - Math.sqrt(2e-4)) < 3e-5, `${apart}`);
});

test("if only one animation has a body, the animations differ once the body moves", () => {
  // Goal: a body that only one animation has is a difference. Method: omit the body from the second
  // animation.
  const rows: Row[] = [{ body: 0, v: [1, 0, 0] }, { body: 0, start: 1, mode: "resting" }];
  const a = { recording: recordingFrom(rows, 2), shift: 0 };
  const b = { recording: recordingFrom([], 2), shift: 0 };
  const t = whereTheyPart(a, b, 0.25);
  assert.ok(t !== null && Math.abs(t - 0.25) < 3e-5, `${t}`);
});

test("the clock pauses at the end, loops, and stops", () => {
  // Goal: the clock plays, loops and ends. Method: advance time by hand, in steps of at most 0.1 s.
  const clock = new Clock();
  clock.setRange({ from: -1, to: 1 });
  clock.seek(0.95);
  clock.play();
  clock.setSpeed(0.5);
  assert.equal(clock.advance(0.05), false);
  assert.ok(Math.abs(clock.time - 0.975) < 1e-12);
  clock.advance(10);
  assert.equal(clock.time, 1);
  for (let i = 0; i < 7; ++i) clock.advance(0.1);
  assert.equal(clock.time, 1);
  clock.advance(0.11);
  clock.advance(0.1);
  assert.ok(clock.time < 0);
  clock.isLooping = false;
  clock.seek(0.99);
  assert.equal(clock.advance(0.1), true);
  assert.equal(clock.isPlaying, false);
  clock.play();
  assert.equal(clock.time, -1);
});
