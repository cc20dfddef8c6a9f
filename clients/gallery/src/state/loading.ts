// Reads archives and keeps what is shown up to date. A run that grows brings a new generation: its
// table is read at once (questions are answered of the newest generation alone), but what has come
// waits until it is asked for, so that nothing jumps. So does another run's archive that has taken the
// place of the one that is shown: what was read of that one stays (replacing() in derived.ts).
import { SourceError, type GallerySource } from "../data/source";
import { nameOf, type ArchiveSummary, type GalleryState, type Table } from "../data/types";
import type { AppState, Distances, Loaded, QueryAnswer, ShownGroups } from "./app-state";
import { askFind } from "./asking";
import { replacing } from "./derived";
import { allEntries, ascending, type Entries } from "./entry-sets";
import { say, sentenceOf } from "./messages";
import type { Page } from "./page";
import { nothingSelected } from "./selection";
import { asKept } from "./sorting";
import { Latest, type Store } from "./store";

const retryMs = 1000;

export class Loading {
  private readonly latest = new Latest();
  private retry: ReturnType<typeof setTimeout> | undefined;
  private isUnderWay = "";

  constructor(
    private readonly store: Store<AppState>,
    private readonly source: GallerySource,
  ) {}

  /** Begins to listen; returns what ends it. */
  start(): () => void {
    const end = this.source.onChange({
      gallery: (gallery) => this.see(gallery),
      source: (source) => {
        const before = this.store.state.source;
        this.store.set({ source });
        if (before !== "here" && source === "here") void this.lookAgain();
      },
    });
    void this.lookAgain();
    return () => {
      end();
      clearTimeout(this.retry);
    };
  }

  async lookAgain(): Promise<void> {
    try {
      this.see(await this.source.gallery());
    } catch (error) {
      this.failed(error);
    }
  }

  /** Reads whatever archive the page is now about. */
  see(gallery: GalleryState): void {
    this.store.set({ gallery });
    const { loaded, page } = this.store.state;
    const archive = wantedArchive(gallery, page.run, page.archive) ?? standIn(gallery, loaded);
    if (archive === undefined) {
      this.store.set({ loadFailure: "There are no archives to show." });
      return;
    }
    const isOther = loaded === null || loaded.run !== archive.run || loaded.id !== archive.id;
    // page.run is the one that is shown until a person wants another.
    if (page.run === loaded?.run && replacing(this.store.state)?.id === archive.id) return;
    if (isOther && (archive.state === "reading" || (archive.is_beginning && hasNames(page)))) {
      this.store.set({ loadFailure: "" });
      return;
    }
    // Where a gallery was started again, what is shown is more.
    if (!isOther && archive.is_beginning && !this.store.state.isBeginning) return;
    if (archive.state !== "ready") {
      // What was read of it stays on the page; the header says why it isn't as it was.
      if (isOther)
        this.store.set({ loaded: null, loadFailure: archive.words || `${archive.name} cannot be read.` });
      return;
    }
    if (isOther || loaded.generation !== archive.generation) void this.load(archive);
  }

  /** Shows all that has come. */
  takeOffered(): void {
    const { loaded, gallery } = this.store.state;
    if (loaded === null) return;
    const archive = gallery?.archives.find(({ id, run }) => id === loaded.id && run === loaded.run);
    this.store.set({
      visible: allEntries(loaded.names.length),
      asOf: archive?.as_of ?? loaded.archive.as_of,
      isBeginning: archive?.is_beginning ?? false,
    });
  }

  private async load(archive: ArchiveSummary): Promise<void> {
    const key = `${archive.id} ${archive.run} ${archive.generation}`;
    if (this.isUnderWay === key) return;
    this.isUnderWay = key;
    const isWanted = this.latest.begin();
    const before = this.store.state.loaded;
    const goesOn = before !== null && before.run === archive.run && before.id === archive.id;
    try {
      const [table, scene, looks] = await Promise.all([
        this.source.table(archive.id),
        goesOn ? before.scene : this.source.scene(archive.id),
        goesOn ? before.looks : this.source.looks(archive.id),
      ]);
      if (!isWanted()) return;
      if (table.generation !== archive.generation) {
        // It was read anew in the meantime, perhaps as another run's.
        void this.lookAgain();
        return;
      }
      const loaded = loadedOf(archive, table, scene, looks);
      if (goesOn) await this.goOn(before, loaded, isWanted);
      else this.begin(archive, loaded);
    } catch (error) {
      if (isWanted()) this.failed(error);
    } finally {
      if (this.isUnderWay === key) this.isUnderWay = "";
    }
  }

  private begin(archive: ArchiveSummary, loaded: Loaded): void {
    const { page, selection } = this.store.state;
    const isAsked = page.run === "" || page.run === archive.run;
    if (!isAsked) say(this.store, `There is no run ${page.run.slice(0, 8)} here. ${archive.name} is shown instead.`);
    // Names are a run's own: another's are left behind.
    const sort = page.sort.by === "alike" ? asKept : page.sort;
    const ofOther = { archive: "", path: [], playing: [], timeS: null, plot: "", sort };
    const kept = isAsked ? page : { ...page, ...ofOther };
    this.store.set({
      loaded,
      loadFailure: "",
      page: { ...kept, run: archive.run },
      selection: isAsked ? selection : nothingSelected,
      visible: allEntries(loaded.names.length),
      asOf: archive.as_of,
      isBeginning: archive.is_beginning,
      answers: new Map(),
      groups: null,
      opened: kept.path.map(() => null),
      distances: null,
    });
  }

  /** The same animations stay on the page under their new entries. */
  private async goOn(before: Loaded, loaded: Loaded, isWanted: () => boolean): Promise<void> {
    const texts = [...this.store.state.answers.keys()];
    const answers = new Map<string, QueryAnswer>();
    for (const text of texts) answers.set(text, await askFind(this.source, loaded, text));
    if (!isWanted()) return;
    const { state } = this.store;
    const moved = movedEntries(before, loaded);
    const move = (entries: Entries): Entries =>
      ascending(Array.from(entries, (entry) => moved[entry] ?? -1).filter((entry) => entry >= 0));
    const visible = move(state.visible);
    this.store.set({
      loaded,
      loadFailure: "",
      visible,
      answers,
      groups: movedGroups(state.groups, moved, move),
      opened: state.opened.map((entries) => entries && move(entries)),
      distances: movedDistances(state.distances, moved, loaded.names.length),
    });
    const lost = state.visible.length - visible.length;
    if (lost > 0) say(this.store, `${lost} of the animations shown are no longer in the archive.`);
  }

  private failed(error: unknown): void {
    const failure = error instanceof SourceError ? error : null;
    if (failure?.kind === "aborted") return;
    // "away" ends by itself: the source says when it is back.
    if (this.store.state.loaded === null)
      this.store.set({ loadFailure: failure?.kind === "reading" ? "" : sentenceOf(error) });
    if (failure?.kind === "away" || failure?.kind === "refused") return;
    clearTimeout(this.retry);
    this.retry = setTimeout(() => void this.lookAgain(), retryMs);
  }
}

/**
 * Of the run that is asked for: the one of this name, else one that can be read. One that never could be
 * read has no run, and is asked for by its name alone.
 */
export function wantedArchive(gallery: GalleryState, run: string, name: string): ArchiveSummary | undefined {
  const ofRun = gallery.archives.filter((archive) => (run === "" ? archive.name === name : archive.run === run));
  return ofRun.find((archive) => archive.name === name) ?? ofRun.find(isReady) ?? ofRun[0];
}

/** What has come to be in the place of the archive that was shown, else the first that can be read. */
function standIn(gallery: GalleryState, loaded: Loaded | null): ArchiveSummary | undefined {
  const { archives } = gallery;
  return archives.find(({ id }) => id === loaded?.id) ?? archives.find(isReady) ?? archives[0];
}

/** Of animations that may come behind an archive's beginning. */
function hasNames(page: Page): boolean {
  const { playing, path, selected, sort } = page;
  return playing.length + path.length + selected.length > 0 || sort.by === "alike";
}

function isReady(archive: ArchiveSummary): boolean {
  return archive.state === "ready";
}

function loadedOf(
  archive: ArchiveSummary,
  table: Table,
  scene: Loaded["scene"],
  looks: Loaded["looks"],
): Loaded {
  const names: string[] = [];
  const entryOf = new Map<string, number>();
  for (let entry = 0; entry < table.entries; entry++) {
    const name = nameOf(table, entry);
    names.push(name);
    entryOf.set(name, entry);
  }
  const bodies = scene.features.filter((feature) => feature.kind === "body").length;
  const { generation } = table;
  const { id, run } = archive;
  return { id, run, generation, archive, scene, looks, table, names, entryOf, bodies };
}

/** By old entry its new one, -1 where it is gone. */
function movedEntries(before: Loaded, now: Loaded): Int32Array {
  return Int32Array.from(before.names, (name) => now.entryOf.get(name) ?? -1);
}

function movedGroups(
  groups: ShownGroups | null,
  moved: Int32Array,
  move: (entries: Entries) => Entries,
): ShownGroups | null {
  if (groups === null) return null;
  const list = groups.list.flatMap((group) => {
    const representative = moved[group.representative] ?? -1;
    return representative < 0 ? [] : [{ ...group, representative, members: move(group.members) }];
  });
  return { ...groups, of: move(groups.of), list };
}

function movedDistances(distances: Distances | null, moved: Int32Array, entries: number): Distances | null {
  if (distances === null) return null;
  const byEntry = new Float64Array(entries).fill(NaN);
  moved.forEach((entry, old) => {
    if (entry >= 0) byEntry[entry] = distances.byEntry[old] ?? NaN;
  });
  return { ...distances, byEntry };
}
