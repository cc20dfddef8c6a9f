// Goal: new animations stay hidden until requested. An archive's first animations are shown while the rest is
// read. Another run's archive doesn't replace the shown one by itself. Method: change or replace a source's
// archive between two checks.
import assert from "node:assert/strict";
import { test } from "node:test";
import type { GallerySource } from "../src/data/source";
import type { ArchiveSummary, GalleryState, Scene, Table } from "../src/data/types";
import { archiveShown, replacing } from "../src/state/derived";
import { Loading } from "../src/state/loading";
import { ofShownRun } from "../src/state/own-run";
import { firstPage, type Page } from "../src/state/page";
import type { NoteKeeping } from "../src/state/note-keeping";
import { initialState, PageActions } from "../src/state/page-actions";
import { Store } from "../src/state/store";

const whole = 9;
const beginning = 4;

function summary(kept: number, isBeginning: boolean): ArchiveSummary {
  return {
    id: 0, name: "a.h5", run: "ab", generation: isBeginning ? 1 : 2, world: "", state: "ready", words: "",
    reading: null, is_beginning: isBeginning, chains: 1, draws: kept, as_of: `scan ${kept}`, warning: "",
    method: "", in_proportion: true, is_live: false, live_words: "",
  };
}

function stateOf(archive: ArchiveSummary): GalleryState {
  return { archives: [archive], left_out: [], notes: { writable: true, words: "" } };
}

function tableOf(entries: number, generation: number): Table {
  return {
    generation, entries, isFind: new Uint8Array(entries), chain: new Float64Array(entries),
    draw: Float64Array.from({ length: entries }, (_, i) => i), values: new Map(), endS: new Float64Array(entries),
  } as unknown as Table;
}

/** A source of the archive that `now` returns, with its draws as animations. */
function sourceOf(now: () => ArchiveSummary, more: object = {}): GallerySource {
  return {
    gallery: () => Promise.resolve(stateOf(now())),
    table: () => Promise.resolve(tableOf(now().draws, now().generation)),
    scene: () => Promise.resolve({ features: [] } as unknown as Scene),
    looks: () => Promise.resolve({}),
    onChange: () => undefined,
    ...more,
  } as unknown as GallerySource;
}

const settled = () => new Promise((resolve) => setTimeout(resolve, 5));

/** The page's state after the source reported an archive's beginning, then the whole archive. */
async function seen(page: Page): Promise<{ first: number | null; then: number; offered: string }> {
  let archive = summary(beginning, true);
  const store = new Store(initialState(page));
  const loading = new Loading(store, sourceOf(() => archive));
  loading.see(stateOf(archive));
  await settled();
  const first = store.state.loaded === null ? null : store.state.visible.length;
  archive = summary(whole, false);
  loading.see(stateOf(archive));
  await settled();
  const then = store.state.visible.length;
  const offered = `${store.state.loaded!.names.length - then} ${store.state.isBeginning ? "more" : "new"}`;
  loading.takeOffered();
  assert.equal(store.state.visible.length, whole);
  assert.equal(store.state.isBeginning, false);
  assert.equal(store.state.asOf, `scan ${whole}`);
  return { first, then, offered };
}

test("the page shows the first animations and then offers the rest", async () => {
  assert.deepEqual(await seen(firstPage), { first: beginning, then: beginning, offered: "5 more" });
});

test("a link that names animations waits for all of them", async () => {
  for (const link of [{ playing: ["c0.8"] }, { selected: ["c0.8"] }, { sort: { by: "alike" as const, to: ["c0.8"] } }])
    assert.deepEqual(await seen({ ...firstPage, ...link } as Page), { first: null, then: whole, offered: "0 new" });
});

test("another run at the same path stays hidden until requested", async () => {
  const shownRun: ArchiveSummary = { ...summary(beginning, false), generation: 1, warning: "of ab" };
  const other: ArchiveSummary = { ...summary(whole, false), run: "cd", generation: 2 };
  let now = shownRun;
  let asked = 0;
  const source = sourceOf(() => now, { animations: () => Promise.resolve([(asked += 1)]) });
  const store = new Store(initialState({ ...firstPage, playing: ["c0.1"] }));
  const loading = new Loading(store, source);
  const page = new PageActions(store, {} as NoteKeeping, () => void loading.lookAgain());
  const own = ofShownRun(source, store);
  const tell = async (archive: ArchiveSummary): Promise<void> => {
    now = archive;
    loading.see(stateOf(archive));
    await settled();
  };
  await tell(shownRun);
  assert.equal(replacing(store.state), null);
  await own.animations(0, ["c0.1"], 1);
  assert.equal(asked, 1);
  page.select("c0.2", "toggle");
  const { loaded, visible, page: before, message } = store.state;

  // The page's data and messages don't change.
  for (const generation of [2, 3]) await tell({ ...other, generation });
  assert.equal(store.state.loaded, loaded);
  assert.equal(store.state.visible, visible);
  assert.equal(store.state.page, before);
  assert.equal(store.state.message, message);
  assert.deepEqual(store.state.selection.names, ["c0.2"]);
  assert.equal(replacing(store.state)?.run, "cd");
  assert.equal(archiveShown(store.state)?.warning, "of ab");
  // The other run has animations with the same names.
  await assert.rejects(own.animations(0, ["c0.1"], 1), /a\.h5 .*another run/);
  assert.equal(asked, 1);

  // The old run returns, and is requested again.
  await tell({ ...shownRun, generation: 4 });
  assert.equal(replacing(store.state), null);
  assert.equal(store.state.loaded?.generation, 4);
  assert.deepEqual(store.state.page.playing, ["c0.1"]);

  // After a request, the page shows the other run, without the old run's names.
  await tell({ ...other, generation: 5 });
  page.showArchive("cd", "");
  await settled();
  assert.equal(store.state.loaded?.run, "cd");
  assert.equal(store.state.visible.length, whole);
  assert.deepEqual([store.state.page.playing, store.state.selection.names], [[], []]);
  assert.equal(replacing(store.state), null);
  await own.animations(0, ["c0.1"], 1);
  assert.equal(asked, 2);
});

test("a link to a missing run shows another archive", async () => {
  const store = new Store(initialState({ ...firstPage, run: "ef" }));
  new Loading(store, sourceOf(() => summary(whole, false))).see(stateOf(summary(whole, false)));
  await settled();
  assert.equal(store.state.loaded?.run, "ab");
  assert.match(store.state.message.words, /\bef\b.*\ba\.h5\b/);
});

test("an archive that changes during loading is loaded again", async () => {
  let looks = 0;
  const now = { ...summary(whole, false), run: "cd", generation: 3 };
  const gallery = () => {
    looks += 1;
    return Promise.resolve(stateOf(now));
  };
  const source = sourceOf(() => now, { gallery });
  const store = new Store(initialState(firstPage));
  new Loading(store, source).see(stateOf(summary(whole, false)));
  await settled();
  assert.equal(looks, 1);
  // One run's names must not be used with another run's table.
  assert.deepEqual([store.state.loaded?.run, store.state.loaded?.generation], ["cd", 3]);
});
