import assert from "node:assert/strict";
import { test } from "node:test";
import { eventsOf, firstContactS, nextTime, previousTime } from "../src/motion/events";
import { Pose } from "../src/motion/pose";
import { orientationInto, velocityInto } from "../src/motion/segments";
import { recordingFrom, segmentsFrom } from "./recordings";

const pose = new Pose();

function near(value: number, expected: number, tolerance: number, what: string): void {
  assert.ok(Math.abs(value - expected) <= tolerance, `${what}: ${value} instead of ${expected}`);
}

test("a thrown body follows its parabola and rests at its last segment", () => {
  // Goal: positions and velocities equal the closed forms. Method: evaluate a throw and a rest that were
  // computed by hand.
  const recording = recordingFrom([
    { start: 1, p: [0, 1, 2], v: [3, 0, 4], a: [0, 0, -10] },
    { start: 2, mode: "resting", cause: "rest", p: [3, 1, 1] },
  ]);
  assert.equal(recording.poseAt(0, 0.999, pose), false);
  assert.equal(recording.poseAt(0, 1.5, pose), true);
  near(pose.x, 1.5, 1e-15, "x");
  near(pose.y, 1, 1e-15, "y");
  near(pose.z, 2 + 2 - 1.25, 1e-15, "z");
  velocityInto(recording.segments, recording.segmentAt(0, 1.5), 1.5, pose);
  near(pose.z, -1, 1e-15, "velocity");
  recording.poseAt(0, 1e6, pose);
  assert.deepEqual([pose.x, pose.y, pose.z], [3, 1, 1]);
  assert.equal(recording.endS, 2);
});

test("at a border the later segment applies; if several start there, the last one applies", () => {
  // Goal: the segment in force at a time follows the rule of common/motion/path.h. Method: use three
  // segments, two of which start at the same time.
  const recording = recordingFrom([
    { start: 0, p: [0, 0, 0] }, { start: 1, p: [1, 0, 0] }, { start: 1, p: [2, 0, 0] },
  ]);
  const at = (t: number): number => (recording.poseAt(0, t, pose) ? pose.x : NaN);
  assert.equal(at(1 - 2 ** -52), 0);
  assert.equal(at(1), 2);
  assert.equal(at(0), 0);
});

test("a body that never enters has no pose; each other body moves by its own segments", () => {
  // Goal: the table of first segments is right. Method: let bodies 0 and 2 of four enter.
  const recording = recordingFrom([{ body: 0, p: [1, 0, 0] }, { body: 2, start: 3, p: [2, 0, 0] }], 4);
  assert.deepEqual([0, 1, 2, 3].map((body) => recording.enters(body)), [true, false, true, false]);
  assert.equal(recording.poseAt(1, 5, pose), false);
  assert.equal(recording.poseAt(2, 2, pose), false);
  assert.equal(recording.poseAt(2, 3, pose), true);
  assert.equal(pose.x, 2);
  assert.equal(recording.startS, 0);
});

test("a recording throws if the order, body or time of a segment is invalid", () => {
  // Goal: an invalid recording throws. Method: try each fault alone.
  assert.throws(() => recordingFrom([{ start: 1 }, { start: 0 }]));
  assert.throws(() => recordingFrom([{ body: 1 }, { body: 0 }], 2));
  assert.throws(() => recordingFrom([{ body: 1 }], 1));
  assert.throws(() => recordingFrom([{ start: NaN }]));
});

test("the rotation around a fixed axis equals the closed form", () => {
  // Goal: the angle is w s + a s^2 / 2 around one axis. Method: rotate around z, far beyond a full turn.
  const segments = segmentsFrom([{ w: [0, 0, 30], wa: [0, 0, -4] }]);
  for (const t of [0.001, 0.5, 2]) {
    orientationInto(segments, 0, t, pose);
    const half = 0.5 * (30 * t - 2 * t * t);
    near(pose.qw, Math.cos(half), 1e-14, "w");
    near(pose.qz, Math.sin(half), 1e-14, "z");
    near(Math.hypot(pose.qx, pose.qy), 0, 0, "no other axis");
  }
});

test("the rotation about a turning axis solves the differential equation", () => {
  // Goal: the error of orientations is below 1e-6 rad. Method: solve q' = w q / 2 by an explicit fourth-order
  // method in 20,000 steps.
  const w = [9, -14, 6] as const;
  const a = [-40, 25, 60] as const;
  const end = 0.4;
  const steps = 20_000;
  let q: [number, number, number, number] = [1, 0, 0, 0];
  const slope = (t: number, at: readonly number[]): number[] => {
    const [x, y, z] = [0, 1, 2].map((k) => w[k]! + t * a[k]!) as [number, number, number];
    const [qw, qx, qy, qz] = at as [number, number, number, number];
    return [
      0.5 * (-x * qx - y * qy - z * qz), 0.5 * (x * qw + y * qz - z * qy),
      0.5 * (y * qw + z * qx - x * qz), 0.5 * (z * qw + x * qy - y * qx),
    ];
  };
  const h = end / steps;
  const plus = (at: readonly number[], k: readonly number[], s: number): number[] =>
    at.map((c, i) => c + s * k[i]!);
  for (let i = 0; i < steps; ++i) {
    const t = i * h;
    const k1 = slope(t, q);
    const k2 = slope(t + h / 2, plus(q, k1, h / 2));
    const k3 = slope(t + h / 2, plus(q, k2, h / 2));
    const k4 = slope(t + h, plus(q, k3, h));
    q = q.map((c, j) => c + (h / 6) * (k1[j]! + 2 * k2[j]! + 2 * k3[j]! + k4[j]!)) as typeof q;
  }
  orientationInto(segmentsFrom([{ w, wa: a }]), 0, end, pose);
  const dot = Math.abs(pose.qw * q[0] + pose.qx * q[1] + pose.qy * q[2] + pose.qz * q[3]);
  const off = Math.hypot(pose.qw - q[0], pose.qx - q[1], pose.qy - q[2], pose.qz - q[3]);
  assert.ok(dot > 0.999 && 2 * off < 1e-6, `${2 * off} rad`);
});

test("a resting body doesn't turn", () => {
  // Goal: a resting body's orientation is constant, as in common/motion/segment.cpp. Method: give a resting
  // segment an angular velocity.
  orientationInto(segmentsFrom([{ mode: "resting", w: [1, 2, 3] }]), 0, 9, pose);
  assert.deepEqual([pose.qw, pose.qx, pose.qy, pose.qz], [1, 0, 0, 0]);
});

test("events are in order, and a collision of two bodies is one event", () => {
  // Goal: each hit is one event. Method: let bodies 0 and 1 meet at 1 s, and body 1 hit a wall (feature 5)
  // later.
  const recording = recordingFrom([
    { body: 0, v: [1, 0, 0] },
    { body: 0, start: 1, cause: "hit", partner: 1, p: [1, 0, 0], v: [-1, 0, 0] },
    { body: 1, start: 0.5, p: [2, 0, 0] },
    { body: 1, start: 1, cause: "hit", partner: 0, p: [1.1, 0, 0] },
    { body: 1, start: 2, cause: "hit", partner: 5, p: [4, 0, 0] },
    { body: 1, start: 3, cause: "rest", mode: "resting", p: [4, 0, 0] },
  ], 2);
  const events = eventsOf(recording);
  assert.deepEqual(events.map(({ timeS, body, partner, cause }) => [timeS, body, partner, cause]), [
    [0, 0, -1, "start"], [0.5, 1, -1, "start"], [1, 0, 1, "hit"], [2, 1, 5, "hit"], [3, 1, -1, "rest"],
  ]);
  assert.deepEqual(events[2]?.change_mps, [-2, 0, 0]);
  assert.equal(firstContactS(recording), 1);
  assert.equal(firstContactS(recordingFrom([{ start: 0 }, { start: 7, cause: "rest" }])), 7);
});

test("stepping between events always advances", () => {
  // Goal: steps skip times that equal the present time. Method: step in both directions.
  const times = [0, 1, 1, 1 + 1e-12, 2];
  assert.equal(nextTime(times, -1), 0);
  assert.equal(nextTime(times, 0), 1);
  assert.equal(nextTime(times, 1), 2);
  assert.equal(nextTime(times, 2), null);
  assert.equal(previousTime(times, 2), 1 + 1e-12);
  assert.equal(previousTime(times, 1), 0);
  assert.equal(previousTime(times, 0), null);
});
