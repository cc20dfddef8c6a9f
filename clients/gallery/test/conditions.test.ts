// Goal: conditions built from fields have the right text in the query language (docs/BROWSING.md). Method:
// build each kind of condition, including names that need quotes and ranges with missing limits.
import assert from "node:assert/strict";
import { test } from "node:test";
import {
  kindsOfBodies,
  missingIn,
  openRange,
  queryOf,
  type Condition,
  type Who,
} from "../src/state/conditions";
import { joined, placeOfColumn, quotedName, shortNumber } from "../src/state/query-text";

const openBox = { x: openRange, y: openRange, z: openRange };
const die: Who = { kind: "body", name: "die 1" };
const box = { ...openBox, x: { low: 0, high: 0.02 }, y: { low: -0.005, high: null } };

test("steps with boxes, times and hits become one query, in order", () => {
  const condition: Condition = {
    kind: "steps",
    steps: [
      { kind: "touches", who: die, partner: "table", during: { low: null, high: 0.2 } },
      { kind: "in", who: { kind: "every", of: "" }, box, during: { low: 0.4, high: 0.6 } },
      { kind: "touches", who: { kind: "any", of: "ball" }, partner: "", during: openRange },
    ],
  };
  assert.equal(missingIn(condition), "");
  assert.equal(
    queryOf(condition),
    "die 1 touches table during ..0.2s then every in x 0..20mm y -5mm.. during 0.4..0.6s " +
      "then any ball touches any",
  );
});

test("places of rest, and numbers", () => {
  assert.equal(
    queryOf({
      kind: "ends",
      who: { kind: "any", of: "long ball" },
      box: { ...openBox, z: { low: 0.1, high: null } },
    }),
    'any "long ball" ends in z 100mm..',
  );
  const number = (name: string): string => queryOf({ kind: "number", name, range: { low: -30, high: null } });
  assert.equal(number("log_prior"), "log_prior -30..");
  assert.equal(number("offsets[2]"), "offsets[2] -30..");
  assert.equal(number("start_position_m[0,1]"), "start_position_m[0,1] -30..");
  assert.equal(number("odd-name[1]"), '"odd-name"[1] -30..');
  assert.equal(number("ball 3"), '"ball 3" -30..');
  assert.equal(queryOf({ kind: "number", name: "events", range: { low: null, high: 40 } }), "events ..40");
});

test("names are quoted if the language would misread them", () => {
  assert.equal(quotedName("die 12"), "die 12");
  assert.equal(quotedName("west wall"), "west wall");
  for (const name of ["x", "balls in row", "3 balls", "ball  1", "a-b", "die 1b", "1", "", "über"])
    assert.equal(quotedName(name), `"${name}"`);
  assert.equal(quotedName('say "hi" \\'), '"say \\"hi\\" \\\\"');
});

test("missing parts are reported", () => {
  const steps = (step: object): Condition => ({
    kind: "steps",
    steps: [{ kind: "in", who: die, box, during: openRange, ...step }],
  });
  assert.equal(missingIn(steps({})), "");
  assert.match(missingIn(steps({ box: openBox })), /box/);
  assert.match(missingIn(steps({ during: { low: 2, high: 1 } })), /limit/);
  assert.match(missingIn({ kind: "number", name: "a", range: openRange }), /limit/);
});

test("joined queries respect operator precedence", () => {
  assert.equal(joined([]), "");
  assert.equal(joined([{ text: "a < 1 or b < 1", isNot: false }]), "a < 1 or b < 1");
  assert.equal(
    joined([
      { text: "a < 1 or b < 1", isNot: false },
      { text: "c < 1", isNot: true },
    ]),
    "(a < 1 or b < 1) and not (c < 1)",
  );
});

test("numbers are short and exact", () => {
  assert.equal(shortNumber(0.1 + 0.2), "0.3");
  assert.equal(shortNumber(-0), "0");
  assert.equal(shortNumber(1e-9), "1e-9");
});

test("a kind is a name that several numbered bodies share", () => {
  assert.deepEqual(kindsOfBodies(["die 1", "die 2", "ball 1", "cube"]), ["die"]);
});

test("a column number counts characters, not UTF-16 units", () => {
  assert.equal(placeOfColumn("a😀b", 1), 0);
  assert.equal(placeOfColumn("a😀b", 3), 3);
  assert.equal(placeOfColumn("ab", 9), 2);
});
