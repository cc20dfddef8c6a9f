import assert from "node:assert/strict";
import { test } from "node:test";
import { unpack } from "../src/data/packed";
import { SourceError } from "../src/data/source";
import { parseQuery } from "../src/search/parse";
import { isMet } from "../src/search/query";
import { readIndex } from "../src/search/search-index";
import { Turns } from "../src/search/turns";
import {
  FEATURES, indexBytes, indexOf, type MadeEntry, NUMBERS, randomEntry, randomNumbers,
} from "./search-scene";
import { ofTier } from "./tiers";

const THINGS = { features: FEATURES, numbers: NUMBERS };

/** A ball thrown up from 1 m to the right; it hits the table, then ball 2, and rests at 1.5 s. */
const KNOWN: MadeEntry = {
  draw: 0,
  end: 1.5,
  paths: [
    [{ start: 0, p: [0, 0, 1], v: [1, 0, 5], a: [0, 0, -10] }, { start: 1, p: [1, 0, 1], v: [1, 0, 0] },
      { start: 1.5, p: [1.5, 0, 1] }],
    [{ start: 1, p: [-1, 0.5, 0.25] }],
    [],
  ],
  contacts: [[1, 0, 3], [1.5, 0, 1]],
  numbers: [-3, 1.5, NaN, 1, 2, Math.PI / 2],
};

test("queries have the documented meaning", async () => {
  // Goal: queries have the documented meaning. Method: query one animation with known answers, in the cases
  // of tests/unit/clients/browse/query_test.cpp.
  const index = await indexOf([KNOWN]);
  const meets = (text: string): boolean => {
    const condition = parseQuery(text, THINGS);
    if ("message" in condition) return assert.fail(`${text}: ${condition.message}`);
    return isMet(condition, index, 0);
  };
  for (const text of [
    "ball 1 in z 2.25..", "ball 1 in z 2.2.. during 400..450ms", "ball 1: x 49..51cm z 2.2..",
    "ball 1 in x 1.5..1.5 during 100s..", "ball 2 in x -2..2 during ..1", "any in x -1..-1",
    "any body in x -1..-1", "every ball ends in z 0.2..1", "ball 1 touches table", "ball 2 touches ball 1", "ball 2 touches any",
    "ball 1 touches table during 1..1s", "ball 1 touches table then ball 1 touches ball 2",
    "ball 1 touches table then ball 1 in z ..9 then ball 1 touches ball 2", "every ball touches any",
    "ball 1 in z 2.2.. then ball 1 touches table then ball 1 in x 1.4..",
    "log_prior -3..-3 and rest_s > 1499ms", "log_prior <= -3", "face[1] = 2", "turn 89..91deg",
    "log_prior = 0 and log_prior = 0 or log_prior = -3",
    "not log_prior = 0 and not (log_prior = -3 and ball 2 touches table)",
  ]) assert.ok(meets(text), text);
  for (const text of [
    "ball 1 in z 2.251..", "ball 1 in z 2.2.. during 0..300ms", "ball 1: x 80..90cm z 2.2..",
    "ball 2 in x -2..2 during ..0.99", "\"odd \\\"one\\\"\" in x -9..9", "every in x -1..-1",
    "every body in x -1..-1",
    "every ball ends in z 0.5..1", "ball 2 touches table", "ball 1 touches table during 1001ms..",
    "ball 1 touches ball 2 then ball 1 touches table", "every ball touches table",
    "ball 1 touches table then ball 1 touches table", "ball 1 touches table then ball 1 in z 2..",
    "log_prior < -3", "log_prior = 0 and (log_prior = 0 or log_prior = -3)", "landing_m ..9",
    "not landing_m ..9 and landing_m 0..",
  ]) assert.ok(!meets(text), text);
});

test("any text yields an error or a query", async () => {
  // Goal: parsing never throws, and the columns of all errors are within the text. Method: parse random texts
  // of the language's tokens.
  const random = randomNumbers(26);
  const index = await indexOf([KNOWN]);
  const signs = [
    "any ", "every ", "ball 1 ", "in ", "x ", "..", "0.5", "mm", "\"", "\\", "(", ")", "<", "=", "[", "]",
    ",", ":", "\n", "é", "\u0001", "\ud800", "then ", "not ", "and ", "touches ", "ends ", "during "];
  for (let n = 0; n < ofTier(2000, 20_000); ++n) {
    let text = "";
    for (let i = Math.floor(12 * random()); i > 0; --i) text += signs[Math.floor(signs.length * random())]!;
    const found = parseQuery(text, THINGS);
    if ("message" in found) assert.ok(found.column >= 1 && found.column <= text.length + 1, text);
    else isMet(found, index, 0);
  }
});

test("an invalid index file is refused", async () => {
  // Goal: nothing of an invalid file is used. Method: change one column at a time.
  const random = randomNumbers(1);
  const bytes = indexBytes([randomEntry(0, random), randomEntry(1, random)]);
  const packed = unpack(bytes.buffer as ArrayBuffer);
  for (const [name, change] of [
    ["track_count", 1 << 20], ["piece_acceleration", 1 << 20], ["contact_body", 3], ["contact_partner", 6],
    ["contact_first", 9999], ["draw", null], ["number.2", null], ["piece_position_m", null],
  ] as const) {
    const columns = new Map(packed.columns);
    const column = columns.get(name)!.slice();
    if (change === null) columns.delete(name);
    else columns.set(name, column.fill(change));
    await assert.rejects(readIndex({ head: packed.head, columns }, new Turns()),
      (error) => error instanceof SourceError && error.kind === "torn", name);
  }
  await assert.rejects(readIndex({ head: { ...packed.head as object, bodies: 2 }, columns: packed.columns },
    new Turns()), SourceError);
});
