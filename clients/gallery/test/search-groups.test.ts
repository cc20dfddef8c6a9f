import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { test } from "node:test";
import { unpack } from "../src/data/packed";
import { SourceError } from "../src/data/source";
import { ArchiveSearch } from "../src/search/search";
import { sha256Hex } from "../src/search/sha256";
import { indexBytes, type MadeEntry, randomEntry, randomNumbers } from "./search-scene";
import { ofTier } from "./tiers";

const SEED = 26;

function made(count: number): MadeEntry[] {
  const random = randomNumbers(SEED);
  return Array.from({ length: count }, (_, draw) => randomEntry(draw, random));
}

function searchOf(entries: readonly MadeEntry[]): Promise<ArchiveSearch> {
  return ArchiveSearch.of(unpack(indexBytes(entries).buffer as ArrayBuffer));
}

test("SHA-256 is SHA-256", () => {
  // Goal: the hash that selects animations is correct. Method: compare with Node's hash, for all lengths
  // around a block's end.
  for (let length = 0; length < 200; ++length) {
    const text = "é1f".repeat(length).slice(0, length);
    assert.equal(sha256Hex(text), createHash("sha256").update(text).digest("hex"), text);
  }
});

test("the order of a set doesn't change its groups, and known distances are reused", async () => {
  // Goal: sets below and above 500 animations are grouped. Method: group 700 random animations.
  const search = await searchOf(made(700));
  const some = [5, 3, 9, 250, 17, 44];
  const cases = [[some, "medoids"], [null, "medoids"], [null, "hierarchy"]] as const;
  for (const [entries, by] of cases.slice(0, ofTier(2, 3))) {
    const count = entries?.length ?? 700;
    const { groups, approximate } = await search.groups(entries, 4, by);
    assert.equal(approximate, count > 500);
    assert.deepEqual(groups.flatMap((group) => group.members).sort((a, b) => a - b),
      [...(entries ?? Array(700).keys())].sort((a, b) => a - b));
    for (const group of groups) assert.ok(group.members.includes(group.representative));
    const sizes = groups.map((group) => group.members.length);
    assert.deepEqual(sizes, [...sizes].sort((a, b) => b - a));
    const reversed = [...(entries ?? Array(700).keys())].reverse();
    assert.deepEqual(await (await searchOf(made(700))).groups(reversed, 4, by), { groups, approximate });
    assert.deepEqual(await search.groups(reversed, 4, by), { groups, approximate });
  }
  assert.deepEqual(await search.groups([], 4, "medoids"), { groups: [], approximate: false });
  await assert.rejects(search.groups([700], 1, "medoids"), SourceError);
  await assert.rejects(search.groups(null, 0, "medoids"), SourceError);
});

test("during long work, the page responds, and the work can be aborted", async () => {
  // Goal: during long work, the page can run, and the request can be aborted. Method: count timers while 400
  // animations are grouped.
  const search = await searchOf(made(400));
  let turns = 0;
  const timer = setInterval(() => ++turns, 1);
  await search.groups(null, 12, "medoids");
  clearInterval(timer);
  assert.ok(turns >= 2, `${turns}`);
  const stopped = new AbortController();
  const asked = (await searchOf(made(400))).groups(null, 12, "medoids", { signal: stopped.signal });
  setTimeout(() => stopped.abort(), 1);
  await assert.rejects(asked, (error) => error instanceof SourceError && error.kind === "aborted");
});
