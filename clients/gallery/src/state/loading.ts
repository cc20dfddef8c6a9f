// Loads archives and keeps the page up to date. When a run grows, the page reads the table of the new
// generation at once, because only the newest generation is answered. New animations stay hidden until a
// person requests them, so that the wall doesn't jump. If another run's archive replaces the shown one, the
// loaded data stays (replacing() in derived.ts).
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

  /** Starts to listen. */
  start(): void {
    this.source.onChange({
      gallery: (gallery) => this.see(gallery),
      source: (source) => {
        const before = this.store.state.source;
        this.store.set({ source });
        if (before !== "here" && source === "here") void this.lookAgain();
      },
    });
    void this.lookAgain();
  }

  async lookAgain(): Promise<void> {
    try {
      this.see(await this.source.gallery());
    } catch (error) {
      this.failed(error);
    }
  }

  /** Loads the archive that the page shows, if necessary. */
  see(gallery: GalleryState): void {
    this.store.set({ gallery });
    const { loaded, page } = this.store.state;
    const archive = wantedArchive(gallery, page.run, page.archive) ?? standIn(gallery, loaded);
    if (archive === undefined) {
      this.store.set({ loadFailure: "There are no archives to show." });
      return;
    }
    const isOther = loaded === null || loaded.run !== archive.run || loaded.id !== archive.id;
    // The shown run stays until a person opens another one.
    if (page.run === loaded?.run && replacing(this.store.state)?.id === archive.id) return;
    if (isOther && (archive.state === "reading" || (archive.is_beginning && hasNames(page)))) {
      this.store.set({ loadFailure: "" });
      return;
    }
    // After a gallery's restart, the page shows more animations than the new gallery has read so far.
    if (!isOther && archive.is_beginning && !this.store.state.isBeginning) return;
    if (archive.state !== "ready") {
      // Loaded data stays on the page; the header shows the reason.
      if (isOther)
        this.store.set({ loaded: null, loadFailure: archive.words || `${archive.name} cannot be read.` });
      return;
    }
    if (isOther || loaded.generation !== archive.generation) void this.load(archive);
  }

  /** Shows all new animations. */
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
        // The archive was read again meanwhile, perhaps with another run.
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
    // Names are only valid within a run: drop the names of another run.
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

  /** Keeps the same animations on the page, with their new entries. */
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
    // For "away" no retry is needed, because the source reports when the server answers.
    if (this.store.state.loaded === null)
      this.store.set({ loadFailure: failure?.kind === "reading" ? "" : sentenceOf(error) });
    if (failure?.kind === "away" || failure?.kind === "refused") return;
    clearTimeout(this.retry);
    this.retry = setTimeout(() => void this.lookAgain(), retryMs);
  }
}

/** The archive to show: the requested run's archive with this name, else one that is readable. An archive
 *  that was never readable has no run, and is found by its name alone. */
export function wantedArchive(gallery: GalleryState, run: string, name: string): ArchiveSummary | undefined {
  const ofRun = gallery.archives.filter((archive) => (run === "" ? archive.name === name : archive.run === run));
  return ofRun.find((archive) => archive.name === name) ?? ofRun.find(isReady) ?? ofRun[0];
}

/** The archive at the place of the shown one, else the first readable archive. */
function standIn(gallery: GalleryState, loaded: Loaded | null): ArchiveSummary | undefined {
  const { archives } = gallery;
  return archives.find(({ id }) => id === loaded?.id) ?? archives.find(isReady) ?? archives[0];
}

/** Whether the page names animations that may not be among the archive's first ones. */
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

/** New entries by old entry; -1 if the animation was removed. */
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
