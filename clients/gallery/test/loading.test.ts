// Goal: what comes of an archive waits until it is asked for, and an archive's beginning is shown while the
// rest is read. Method: a source whose archive grows between two looks.
import assert from "node:assert/strict";
import { test } from "node:test";
import type { GallerySource } from "../src/data/source";
import type { ArchiveSummary, GalleryState, Scene, Table } from "../src/data/types";
import { Loading } from "../src/state/loading";
import { firstPage, type Page } from "../src/state/page";
import { initialState } from "../src/state/page-actions";
import { Store } from "../src/state/store";

const whole = 9;
const beginning = 4;

function summary(kept: number, isBeginning: boolean): ArchiveSummary {
  return {
    id: 0, name: "a.h5", run: "ab", generation: isBeginning ? 1 : 2, world: "", state: "ready", words: "",
    reading: null, kept, finds: 0, is_beginning: isBeginning, keep_max: 0, chains: 1, draws: 9, scans: 9,
    as_of: `scan ${kept}`, warning: "", method: "", in_proportion: true, satisfied: null, is_live: false,
    live_words: "",
  };
}

function stateOf(archive: ArchiveSummary): GalleryState {
  return { version: "", archives: [archive], left_out: [], notes: { writable: true, words: "" } };
}

function tableOf(entries: number, generation: number): Table {
  return {
    generation, entries, isFind: new Uint8Array(entries), chain: new Float64Array(entries),
    draw: Float64Array.from({ length: entries }, (_, i) => i), values: new Map(), endS: new Float64Array(entries),
  } as unknown as Table;
}

/** The page's state as an archive's beginning, then the whole of it is told. */
async function seen(page: Page): Promise<{ first: number | null; then: number; offered: string }> {
  let archive = summary(beginning, true);
  const source = {
    gallery: () => Promise.resolve(stateOf(archive)),
    table: () => Promise.resolve(tableOf(archive.kept, archive.generation)),
    scene: () => Promise.resolve({ features: [] } as unknown as Scene),
    looks: () => Promise.resolve({}),
    onChange: () => () => undefined,
  } as unknown as GallerySource;
  const store = new Store(initialState(page));
  const loading = new Loading(store, source);
  const settle = () => new Promise((resolve) => setTimeout(resolve, 5));
  loading.see(stateOf(archive));
  await settle();
  const first = store.state.loaded === null ? null : store.state.visible.length;
  archive = summary(whole, false);
  loading.see(stateOf(archive));
  await settle();
  const then = store.state.visible.length;
  const offered = `${store.state.loaded!.names.length - then} ${store.state.isBeginning ? "more" : "new"}`;
  loading.takeOffered();
  assert.equal(store.state.visible.length, whole);
  assert.equal(store.state.isBeginning, false);
  assert.equal(store.state.asOf, `scan ${whole}`);
  return { first, then, offered };
}

test("a beginning is shown, and the rest is offered as more", async () => {
  assert.deepEqual(await seen(firstPage), { first: beginning, then: beginning, offered: "5 more" });
});

test("a link that names animations waits for all of them", async () => {
  for (const link of [{ playing: ["0.8"] }, { selected: ["0.8"] }, { sort: { by: "alike" as const, to: ["0.8"] } }])
    assert.deepEqual(await seen({ ...firstPage, ...link } as Page), { first: null, then: whole, offered: "0 new" });
});
