import assert from "node:assert/strict";
import { afterEach, test } from "node:test";
import { gzipSync } from "node:zlib";
import { Once } from "../src/data/once";
import type { Packed } from "../src/data/packed";
import { pack } from "./pack";
import { createSavedSource } from "../src/data/saved";
import { SatisfiedDraws } from "../src/data/saved-shares";
import { type GallerySource, SourceError } from "../src/data/source";
import type { Column, NotePatch } from "../src/data/types";
import { type Script, FakeDocument, FakeStorage } from "./fake-page";
import { ofTier } from "./tiers";

const RUN = "ab12";
const BODIES = 1;
/** More than two files of animations. */
const ENTRIES = 70;

function json(value: unknown): Script {
  return { kind: "json", text: JSON.stringify(value) };
}

function packed(head: unknown, columns: readonly (readonly [string, Column])[]): Script {
  return { kind: "gz", text: gzipSync(pack(head, new Map(columns))).toString("base64") };
}

function names(): string[] {
  return Array.from({ length: ENTRIES }, (_, entry) => `c0.${10 * entry}`);
}

/** Columns shared by the table and the index: draw 10 * entry of chain 0. */
function rows(): (readonly [string, Column])[] {
  return [
    ["is_find", new Uint8Array(ENTRIES)],
    ["chain", new Uint32Array(ENTRIES)],
    ["draw", Float64Array.from({ length: ENTRIES }, (_, entry) => 10 * entry)],
    ["in_proportion", new Uint8Array(ENTRIES).fill(1)],
    ["end_s", new Float64Array(ENTRIES).fill(1)],
    ["lineage", new Float64Array(ENTRIES)],
    ["number.0", Float64Array.from({ length: ENTRIES }, (_, entry) => -entry)],
  ];
}

/** Animations first, first + 1, ...: a ball at rest at x = entry. */
function animations(first: number): Script {
  const heads: object[] = [];
  const columns: (readonly [string, Column])[] = [];
  for (let entry = first; entry < Math.min(ENTRIES, first + 32); ++entry) {
    const prefix = `${entry - first}:`;
    heads.push({ name: `c0.${10 * entry}`, end_s: 1, meshes: [], columns: prefix });
    const f64 = (name: string, ...values: number[]): void => {
      columns.push([prefix + name, Float64Array.from(values)]);
    };
    columns.push(
      [`${prefix}body`, Uint32Array.of(0)], [`${prefix}mode`, Uint8Array.of(3)],
      [`${prefix}cause`, Uint8Array.of(0)], [`${prefix}partner`, Int32Array.of(-1)]);
    f64("start_s", 0);
    f64("position_m", entry, 0, 0);
    f64("velocity_mps", 0, 0, 0);
    f64("acceleration_mps2", 0, 0, 0);
    f64("orientation", 1, 0, 0, 0);
    f64("angular_velocity_radps", 0, 0, 0);
    f64("angular_acceleration_radps2", 0, 0, 0);
  }
  return packed({ generation: 1, animations: heads }, columns);
}

/** A gallery of one archive, as `sleight gallery --save` writes it. */
function files(): Map<string, Script> {
  const features = [{ name: "ball", kind: "body", twin_of: 0, body: -1, radius_m: 0.01 }];
  const numbers = [{ name: "log_prior", unit: "1" }];
  const view = { view_low_m: [-1, -1, -1], view_high_m: [100, 1, 1] };
  return new Map<string, Script>([
    ["gallery", json({
      version: "1",
      archives: [
        { id: 0, name: "a.h5", run: RUN, generation: 1, state: "ready", draws: 5, in_proportion: true },
      ],
      left_out: [],
      notes: { writable: false, words: "said by the file" },
    })],
    ["0/scene", json({
      generation: 1, ...view, offsets: false, features, numbers, prior_log_prior: [], request: "",
    })],
    ["0/looks", packed({ generation: 1, meshes: [], own: [] }, [])],
    ["0/table", packed({ generation: 1, entries: ENTRIES, numbers: ["log_prior"] }, rows())],
    ["0/index", packed(
      { generation: 1, run: RUN, entries: ENTRIES, bodies: BODIES, names: names(), numbers, features, ...view },
      [
        ...rows(),
        ["track_first", Uint32Array.from({ length: ENTRIES }, (_, entry) => entry)],
        ["track_count", new Uint32Array(ENTRIES).fill(1)],
        ["piece_start_s", new Float64Array(ENTRIES)],
        ["piece_position_m", Float64Array.from({ length: 3 * ENTRIES }, (_, i) => (i % 3 === 0 ? i / 3 : 0))],
        ["piece_velocity_mps", new Float64Array(3 * ENTRIES)],
        ["piece_acceleration", new Uint32Array(ENTRIES)],
        ["accelerations_mps2", new Float64Array(3)],
        ["contact_first", new Uint32Array(ENTRIES + 1)],
        ["contact_time_s", new Float64Array(0)],
        ["contact_body", new Uint32Array(0)],
        ["contact_partner", new Uint32Array(0)],
      ])],
    ["0/series", json([{ name: "trace.50% ä", title: "t", kind: "trace", group: "" }])],
    ["0/series-trace.50% ä-0", packed({ kind: "trace" }, [["draw", Float64Array.of(1, 2)]])],
    ["0/animations-0", animations(0)],
    ["0/animations-1", animations(32)],
    ["0/animations-2", animations(64)],
  ]);
}

interface Opened {
  readonly source: GallerySource;
  readonly page: FakeDocument;
}

function open(
  change: (all: Map<string, Script>) => void = () => {}, storage: () => Storage = () => new FakeStorage(),
): Opened {
  const all = files();
  change(all);
  const page = new FakeDocument(all);
  const document = page.asDocument();
  return { page, source: createSavedSource({ document, storage, timeoutMs: 200, pauseMs: 20 }) };
}

function isFailure(kind: string): (error: unknown) => boolean {
  return (error) => error instanceof SourceError && error.kind === kind;
}

afterEach(() => {
  globalThis.sleightSaved = undefined;
});

test("each file is loaded only once", async () => {
  // Goal: no file is loaded twice. Method: send each request twice at once and once more later. Check the
  // addresses of the script elements, which must all be removed from the page.
  const { source, page } = open();
  const askAll = (): Promise<unknown> => Promise.all([
    source.gallery(), source.scene(0), source.looks(0), source.table(0), source.seriesTitles(0),
    source.series(0, "trace.50% ä", { chain: "0" }), source.animations(0, ["c0.0", "c0.310"], BODIES),
    source.find("draw 0..20", [{ id: 0, generation: 1 }]),
  ]);
  await Promise.all([askAll(), askAll()]);
  await askAll();
  assert.deepEqual(page.asked.sort(), [
    "data/0/animations-0.js", "data/0/index.js", "data/0/looks.js", "data/0/scene.js",
    "data/0/series-trace.50%25%20%C3%A4-0.js", "data/0/series.js", "data/0/table.js", "data/gallery.js",
  ]);
  assert.equal(page.present, 0);
});

test("animations come from the right files, in the order of the names", async () => {
  // Goal: file K has animations 32 K to 32 K + 31, and other animations' bytes aren't kept. Method: request
  // names from several files, one of them twice. The ball's place identifies the animation.
  const { source, page } = open();
  const entries = [64, 31, 32, 0, 69, 31];
  const found = await source.animations(0, entries.map((entry) => `c0.${10 * entry}`), BODIES);
  assert.deepEqual(found.map(({ name }) => name), entries.map((entry) => `c0.${10 * entry}`));
  for (const [i, { recording }] of found.entries()) {
    assert.equal(recording.segments.position[0], entries[i]);
    assert.equal(recording.segments.position.buffer.byteLength, 24);
  }
  assert.equal(page.asked.filter((src) => src.includes("animations")).length, 3);
  await assert.rejects(source.animations(0, ["c0.5"], BODIES), isFailure("missing"));
});

test("the page itself answers queries, forms groups and sorts by likeness", async () => {
  // Goal: answers have the same form as a server's. Method: place balls on a line, so that answers are
  // obvious.
  const { source } = open();
  const at = { id: 0, generation: 1 };
  const found = await source.find("ball in x 2.5m..5.5m", [at]);
  assert.deepEqual(found, { found: [{ id: 0, entries: [3, 4, 5] }], errors: [] });
  const wrong = await source.find("bell in x 1m..2m", [at]);
  assert.equal(wrong.found.length, 0);
  assert.equal(wrong.errors[0]?.id, 0);
  assert.equal(wrong.errors[0]?.column, 1);
  const { groups, share_words } = await source.groups(
    { ...at, entries: [0, 1, 60, 61, 62], groups: 2, by: "medoids" });
  assert.deepEqual(groups.map(({ members }) => [...members].sort((a, b) => a - b)), [[60, 61, 62], [0, 1]]);
  assert.deepEqual(groups.map(({ share }) => share), [null, null]);
  assert.notEqual(share_words, "");
  const alike = await source.alike({ ...at, to: [10], entries: [1, 9, 30] });
  assert.deepEqual(alike.entries, [9, 1, 30]);
  await assert.rejects(source.find("draw 1", [{ id: 0, generation: 2 }]), isFailure("generation"));
});

test("a failed file is reported, and loaded again at the next request", async () => {
  // Goal: failures throw SourceErrors of the right kind, and no promise hangs. Method: load scripts that fail
  // in each way, then the correct file.
  const faults: readonly (readonly [string, Script | "silent" | "hangs" | null])[] = [
    ["missing", null],
    ["torn", "silent"],
    ["other", "hangs"],
    ["torn", { kind: "json", text: "{}" }],
    ["torn", { kind: "xz", text: "" }],
    ["torn", { kind: "gz", text: "not base64!" }],
    ["torn", { kind: "gz", text: "" }],
    ["torn", { kind: "gz", text: Buffer.from("nothing that gzip made").toString("base64") }],
  ];
  for (const [kind, fault] of faults) {
    const { source, page } = open();
    const whole = page.files.get("0/table")!;
    page.set("0/table", fault);
    await assert.rejects(source.table(0), isFailure(kind), `${kind}: ${JSON.stringify(fault)}`);
    assert.equal(page.present, 0);
    page.set("0/table", whole);
    assert.equal((await source.table(0)).entries, ENTRIES);
  }
  const { source } = open((all) => all.set("gallery", { kind: "json", text: '{"version": ' }));
  await assert.rejects(source.gallery(), isFailure("torn"));
});

test("truncated or changed bytes are detected", async () => {
  // Goal: nothing of a damaged file is used. Method: truncate a table at many places (still valid base64),
  // and change the size in gzip's trailer, which could request any amount of memory.
  const whole = Buffer.from(files().get("0/table")!.text, "base64");
  const damaged: Buffer[] = [];
  for (let length = 0; length < whole.length; length += ofTier(70, 7)) damaged.push(whole.subarray(0, length));
  for (const size of [0, 1, 0x7fffffff, 0xffffffff]) {
    const bytes = Buffer.from(whole);
    bytes.writeUInt32LE(size, bytes.length - 4);
    damaged.push(bytes);
  }
  for (const bytes of damaged) {
    const { source } = open((all) => all.set("0/table", { kind: "gz", text: bytes.toString("base64") }));
    await assert.rejects(source.table(0), isFailure("torn"), `${bytes.length} bytes`);
  }
});

test("an unexpected call has no effect", async () => {
  // Goal: files cannot replace each other. Method: run a script that names another file, and call the function with
  // values of wrong types.
  const { source, page } = open();
  page.set("0/table", { kind: "json", text: "{}", path: "0/scene" });
  await assert.rejects(source.table(0), isFailure("torn"));
  globalThis.sleightSaved?.(1, "json", {});
  globalThis.sleightSaved?.("0/looks", "json", "{}");
  assert.equal((await source.scene(0)).features.length, 1);
});

test("an aborted request ends at once, and the file still loads for others", async () => {
  // Goal: an abort rejects at once and breaks nothing. Method: abort before and during loading.
  const { source, page } = open();
  const ends = new AbortController();
  const asked = source.table(0, { signal: ends.signal });
  ends.abort();
  await assert.rejects(asked, isFailure("aborted"));
  await assert.rejects(source.table(0, { signal: ends.signal }), isFailure("aborted"));
  assert.equal((await source.table(0)).entries, ENTRIES);
  assert.equal(page.asked.length, 1);
});

test("plots that were not saved have an error message", async () => {
  // Goal: a missing chain and a missing diagnosis are reported, and no file is requested for the diagnosis.
  const { source, page } = open();
  const error = await source.series(0, "trace.50% ä", { chain: "9" })
    .then(() => null, (failure: unknown) => failure);
  assert.ok(error instanceof SourceError && error.kind === "missing" && error.message.includes("chain 9"));
  await assert.rejects(source.diagnosis(0), isFailure("missing"));
  assert.ok(!page.asked.some((src) => src.includes("diagnosis")));
});

test("notes are stored by the browser, or last as long as the page", async () => {
  // Goal: storing notes never fails, and another page's notes are kept. Method: use a storage that works, is
  // opened again, is full, or throws at once.
  const note = (text: string): NotePatch => ({ star: true, hidden: false, tags_on: ["a"], note: text });
  const storage = new FakeStorage();
  const first = open(undefined, () => storage).source;
  assert.deepEqual((await first.notes()).notes, { [RUN]: {} });
  const other = open(undefined, () => storage).source;
  assert.equal((await first.changeNotes(RUN, { "c0.10": note("one") })).notes["c0.10"]?.changed, 1);
  assert.equal((await other.changeNotes(RUN, { "c0.20": note("two") })).notes["c0.20"]?.changed, 2);
  assert.equal((await first.changeNotes(RUN, { "c0.10": note("three") })).notes["c0.10"]?.changed, 3);
  const again = (await open(undefined, () => storage).source.notes()).notes[RUN];
  assert.deepEqual(Object.entries(again ?? {}).map(([name, { note: text }]) => [name, text]).sort(),
    [["c0.10", "three"], ["c0.20", "two"]]);
  assert.equal((await first.gallery()).notes.writable, true);

  storage.isFull = true;
  await first.changeNotes(RUN, { "c0.30": note("four") });
  assert.equal((await first.notes()).notes[RUN]?.["c0.30"]?.note, "four");
  assert.equal((await first.gallery()).notes.writable, false);

  const none = open(undefined, () => { throw new Error("SecurityError"); }).source;
  await none.changeNotes(RUN, { "c0.10": note("five") });
  assert.equal((await none.notes()).notes[RUN]?.["c0.10"]?.note, "five");
  assert.equal((await none.gallery()).notes.writable, false);

  storage.isFull = false;
  // Invalid notes are skipped; a name in an older form is read.
  const old = { star: true, hidden: false, tags: [], note: "", changed: 1 };
  storage.setItem(`sleight-notes.${RUN}`, JSON.stringify({ "0.1": { star: 1 }, "0.2": 5, "0.30": old }));
  assert.deepEqual((await open(undefined, () => storage).source.notes()).notes, { [RUN]: { "c0.30": old } });
});

test("the source reports once that it is reachable, and then reports nothing", () => {
  // Goal: nothing is reported later. Method: count a listener's calls.
  const { source } = open();
  const said: string[] = [];
  source.onChange({ gallery: () => said.push("gallery"), source: (state) => said.push(state) });
  assert.deepEqual(said, ["here"]);
  assert.equal(source.isLive, false);
});

test("the least recently used value is dropped first", async () => {
  // Goal: the cache respects its limit, but keeps the newest value even if this value exceeds the limit.
  // Method: store numbers, whose sizes are the numbers themselves, and count loads.
  const once = new Once<number>({ bytesMax: 10, bytesOf: (value) => value });
  const made: string[] = [];
  const get = (key: string, size: number): Promise<number> => once.get(key, () => {
    made.push(key);
    return Promise.resolve(size);
  });
  await get("a", 4);
  await get("b", 4);
  await get("a", 4);
  await get("c", 4);
  await get("a", 4);
  assert.deepEqual(made, ["a", "b", "c"]);
  await get("b", 4);
  await get("huge", 99);
  await get("huge", 99);
  assert.deepEqual(made, ["a", "b", "c", "b", "huge"]);
  await get("a", 4);
  await get("huge", 99);
  assert.deepEqual(made, ["a", "b", "c", "b", "huge", "a", "huge"]);
  await assert.rejects(once.get("d", () => Promise.reject(new Error("no"))));
  assert.equal(await get("d", 1), 1);
});

test("a failed load is repeated after a pause, regardless of the number of requests", async () => {
  // Goal: repeated requests after failures don't load a file all the time. Method: try three times, with two
  // pauses in between.
  const pauseMs = 20;
  const once = new Once<number>({ pauseMs });
  const begun = performance.now();
  for (let tries = 0; tries < 3; ++tries)
    await assert.rejects(once.get("a", () => Promise.reject(new Error("no"))));
  assert.ok(performance.now() - begun > 1.9 * pauseMs);
});

test("the page computes the same shares of groups as the server", () => {
  // The case is computed by hand in tests/unit/clients/gallery_server/shares_test.cpp. One lineage has four
  // draws (three and one of two animations), the other lineage a single draw.
  const column = (values: number[]): Float64Array => Float64Array.from(values);
  const packed = {
    head: {},
    columns: new Map<string, Float64Array>([
      ["satisfied_draws", column([3, 1, 1])], ["chain", column([0, 0, 1])], ["lineage", column([5, 5, 5])],
    ]),
  };
  const draws = SatisfiedDraws.of(packed as unknown as Packed)!;
  const [first, second, third] = draws.shares([[0], [1, 2], []])!;
  assert.equal(first!.value, 3 / 5);
  assert.equal(second!.value, 2 / 5);
  assert.ok(Math.abs(first!.error - Math.sqrt(2 * (0.36 + 0.36)) / 5) < 1e-15);
  assert.equal(third!.error, 0);
  assert.equal(SatisfiedDraws.of({ head: {}, columns: new Map() } as unknown as Packed), null);
});
