// Evaluates segments as the page does, for tests that compare the results with the C++ code:
//
//   `node bundle.mjs evaluate.ts evaluate.mjs && node evaluate.mjs IN OUT`.
//
// IN is a packed file (src/data/packed.ts) with one row per segment. IN has the columns of an animation's
// answer ("body", "start_s", "mode", ... without prefix, in any row order) and "t_s" f64, a time no earlier
// than the segment's start. OUT is packed too: head {"segments": n}, columns "position_m" f64 x3,
// "velocity_mps" f64 x3 and "orientation" f64 x4 (w x y z).
import { readFileSync, writeFileSync } from "node:fs";
import { segmentsOf } from "../src/data/decode";
import { unpack } from "../src/data/packed";
import { pack } from "./pack";
import { Pose } from "../src/motion/pose";
import { orientationInto, positionInto, velocityInto } from "../src/motion/segments";

function evaluate(from: string, to: string): void {
  const bytes = readFileSync(from);
  const { columns } = unpack(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength));
  const segments = segmentsOf(columns, "");
  const times = columns.get("t_s");
  if (!(times instanceof Float64Array) || times.length !== segments.count)
    throw new Error("column 't_s' is missing or has a wrong length");
  const position = new Float64Array(3 * segments.count);
  const velocity = new Float64Array(3 * segments.count);
  const orientation = new Float64Array(4 * segments.count);
  const pose = new Pose();
  for (let i = 0; i < segments.count; ++i) {
    const t = times[i]!;
    velocityInto(segments, i, t, pose);
    velocity.set([pose.x, pose.y, pose.z], 3 * i);
    positionInto(segments, i, t, pose);
    position.set([pose.x, pose.y, pose.z], 3 * i);
    orientationInto(segments, i, t, pose);
    orientation.set([pose.qw, pose.qx, pose.qy, pose.qz], 4 * i);
  }
  writeFileSync(to, pack({ segments: segments.count }, new Map([
    ["position_m", position], ["velocity_mps", velocity], ["orientation", orientation],
  ])));
}

const [from, to] = process.argv.slice(2);
if (from === undefined || to === undefined) {
  console.error("usage: node evaluate.mjs IN OUT");
  process.exitCode = 2;
} else {
  evaluate(from, to);
}
