import assert from "node:assert/strict";
import { test } from "node:test";
import { animationsOf } from "../src/data/decode";
import { unpack } from "../src/data/packed";
import { pack } from "./pack";
import { SourceError } from "../src/data/source";
import type { Column } from "../src/data/types";

const COLUMNS = new Map<string, Column>([
  ["a", Float64Array.of(1.5, -0, NaN)], ["b", Float32Array.of(0.25)], ["c", Uint32Array.of(4294967295)],
  ["d", Int32Array.of(-1, 2, 3)], ["e", Uint16Array.of(65535, 1)], ["f", Uint8Array.of(1, 2, 3, 4, 5)],
  ["g", new Float64Array(0)],
]);

function bytes(): ArrayBuffer {
  return pack({ name: "ä" }, COLUMNS).buffer as ArrayBuffer;
}

function isTorn(error: unknown): boolean {
  return error instanceof SourceError && error.kind === "torn";
}

/** An answer with another head. */
function withHead(json: string, tail: number): ArrayBuffer {
  const text = new TextEncoder().encode(json);
  const start = Math.ceil((4 + text.length) / 8) * 8;
  const all = new Uint8Array(start + tail).fill(0x20, 0, start);
  new DataView(all.buffer).setUint32(0, start - 4, true);
  all.set(text, 4);
  return all.buffer;
}

test("packing and unpacking preserve all bits", () => {
  // Goal: all types and odd lengths survive. Method: pack and unpack columns of each type.
  const { head, columns } = unpack(bytes());
  assert.deepEqual(head, { name: "ä" });
  assert.deepEqual([...columns.keys()], [...COLUMNS.keys()]);
  for (const [name, column] of COLUMNS) {
    const found = columns.get(name);
    assert.equal(found?.constructor, column.constructor, name);
    assert.deepEqual(found, column, name);
  }
});

test("an answer truncated anywhere throws", () => {
  // Goal: nothing of a truncated answer is used. Method: truncate to every length at which more is missing than the
  // padding after the last column.
  const whole = bytes();
  const needed = whole.byteLength - 3;
  for (let length = 0; length < needed; ++length)
    assert.throws(() => unpack(whole.slice(0, length)), isTorn, `${length} bytes`);
});

test("an answer with an invalid header throws", () => {
  // Goal: no column exceeds the answer or has a wrong type. Method: write heads by hand.
  const column = (text: string): string => `{"head":{},"columns":[${text}]}`;
  const heads = [
    "", "[]", "null", "{}", '{"columns":{}}', column("1"), column("{}"),
    column('{"name":1,"type":"f64","offset":0,"count":1}'),
    column('{"name":"a","type":"f16","offset":0,"count":1}'),
    column('{"name":"a","type":"toString","offset":0,"count":1}'),
    column('{"name":"a","type":"f64","offset":4,"count":1}'),
    column('{"name":"a","type":"f64","offset":-8,"count":1}'),
    column('{"name":"a","type":"f64","offset":0,"count":1.5}'),
    column('{"name":"a","type":"f64","offset":0,"count":3}'),
    column('{"name":"a","type":"f64","offset":0,"count":1e300}'),
    column('{"name":"a","type":"u8","offset":0,"count":1},' +
      '{"name":"a","type":"u8","offset":0,"count":1}'),
  ];
  for (const head of heads) assert.throws(() => unpack(withHead(head, 16)), isTorn, head);
  const good = column('{"name":"a","type":"f64","offset":8,"count":1}');
  assert.equal(unpack(withHead(good, 16)).columns.size, 1);
});

test("prefixes distinguish animations, and an unknown body throws", () => {
  // Goal: recordings of one answer don't mix, and invalid recordings throw. Method: use two animations of one
  // segment each, then a body that the scene lacks.
  const columns = new Map<string, Column>();
  for (const [prefix, body] of [["0:", 0], ["1:", 1]] as const) {
    columns.set(`${prefix}body`, Uint32Array.of(body));
    columns.set(`${prefix}start_s`, Float64Array.of(0.5));
    columns.set(`${prefix}mode`, Uint8Array.of(3));
    columns.set(`${prefix}cause`, Uint8Array.of(0));
    columns.set(`${prefix}partner`, Int32Array.of(-1));
    for (const name of ["position_m", "velocity_mps", "acceleration_mps2", "angular_velocity_radps",
      "angular_acceleration_radps2"]) columns.set(prefix + name, Float64Array.of(0, 0, body));
    columns.set(`${prefix}orientation`, Float64Array.of(1, 0, 0, 0));
  }
  const head = { animations: [
    { name: "c0.1", end_s: 0.5, columns: "0:", meshes: [] },
    { name: "find.2", end_s: 0.5, columns: "1:", meshes: [] },
  ] };
  const packed = unpack(pack(head, columns).buffer as ArrayBuffer);
  const [first, second] = animationsOf(packed, 2);
  assert.equal(first?.recording.enters(0), true);
  assert.equal(first?.recording.enters(1), false);
  assert.equal(second?.recording.enters(1), true);
  assert.throws(() => animationsOf(packed, 1), isTorn);
});
