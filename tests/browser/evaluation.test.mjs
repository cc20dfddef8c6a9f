// Goal: the page's code and the C++ code compute the same motion from a segment. Positions agree within 1e-9
// m, velocities within 1e-9 m/s, and orientations within 1e-6 rad. Method: evaluate 100,000 random segments
// of all modes and causes at random times. Some segments have accelerations and spins. Compare the results of
// the page's own modules, bundled for Node, with those of the C++ code.
import assert from "node:assert/strict";
import { existsSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { run, source, temporaryFolder, testProgram } from "./support/programs.mjs";
import { Random } from "./support/random.mjs";

const count = 100_000;
const page = join(source, "clients/gallery");

/** Returns the columns of doubles in a packed file. */
function doublesOf(path) {
  const bytes = readFileSync(path);
  const start = 4 + bytes.readUInt32LE(0);
  const { head, columns } = JSON.parse(bytes.toString("utf8", 4, start));
  const of = new Map(columns.filter(({ type }) => type === "f64").map(({ name, offset, count: many }) =>
    [name, new Float64Array(bytes.buffer.slice(bytes.byteOffset + start + offset,
      bytes.byteOffset + start + offset + 8 * many))]));
  return { head, columns: of };
}

function greatestDifference(a, b) {
  assert.equal(a.length, b.length);
  let greatest = 0;
  for (let i = 0; i < a.length; ++i) {
    const difference = Math.abs(a[i] - b[i]);
    // The negated comparison also detects NaN.
    if (!(difference <= greatest)) greatest = difference;
  }
  return greatest;
}

/** Angle between unit quaternions; q and -q are the same rotation. */
function greatestAngle(a, b) {
  let greatest = 0;
  for (let i = 0; i < a.length; i += 4) {
    let [sum, difference] = [0, 0];
    for (let k = 0; k < 4; ++k) {
      sum += (a[i + k] + b[i + k]) ** 2;
      difference += (a[i + k] - b[i + k]) ** 2;
    }
    const angle = 4 * Math.asin(Math.min(1, Math.sqrt(Math.min(sum, difference)) / 2));
    if (!(angle <= greatest)) greatest = angle;
  }
  return greatest;
}

test("random segments yield the same positions and orientations", () => {
  assert.ok(existsSync(join(page, "node_modules/esbuild")),
    "clients/gallery/node_modules is missing: run deploy/install-deps");
  const folder = temporaryFolder("evaluation");
  const { seed } = new Random();
  run(testProgram("sleight-evaluate-poses"), ["--segments", String(count), String(seed), folder]);
  const bundle = join(folder, "evaluate.mjs");
  run(process.execPath, [join(page, "test/bundle.mjs"), "evaluate.ts", bundle]);
  run(process.execPath, [bundle, join(folder, "segments.bin"), join(folder, "said.bin")]);
  const expected = doublesOf(join(folder, "expected.bin")).columns;
  const said = doublesOf(join(folder, "said.bin"));
  assert.equal(said.head.segments, count);
  const position = greatestDifference(said.columns.get("position_m"), expected.get("position_m"));
  const velocity = greatestDifference(said.columns.get("velocity_mps"), expected.get("velocity_mps"));
  const turn = greatestAngle(said.columns.get("orientation"), expected.get("orientation"));
  console.log(`seed ${seed}: within ${position} m, ${velocity} m/s, ${turn} rad`);
  assert.equal(expected.get("position_m").length, 3 * count);
  assert.ok(position <= 1e-9 && velocity <= 1e-9 && turn <= 1e-6);
  // Check that the comparison isn't trivial: the segments move and turn.
  const began = doublesOf(join(folder, "segments.bin")).columns;
  assert.ok(greatestDifference(began.get("position_m"), expected.get("position_m")) > 1);
  assert.ok(greatestAngle(began.get("orientation"), expected.get("orientation")) > 1);
});
