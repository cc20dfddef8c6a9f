// A gallery saved as static files (`sleight gallery --save`). There is no server: the page reads prepared
// answers (saved-scripts.ts), and searches, groups and compares by itself.
//
// clients/gallery_server/saved_gallery.h describes the files.

import { ArchiveSearch } from "../search/search";
import {
  animationsOf, galleryOf, looksOf, sceneOf, seriesOf, seriesTitlesOf, tableOf,
} from "./decode";
import { Once } from "./once";
import { type Packed, torn, unpack } from "./packed";
import { unzipped } from "./saved-bytes";
import { SavedNotes } from "./saved-notes";
import { SavedScripts } from "./saved-scripts";
import { SatisfiedDraws, type Share } from "./saved-shares";
import { type AskOptions, type GallerySource, SourceError, type SourceListener } from "./source";
import {
  type AlikeAnswer, type AlikeAsk, type Animation, type AnimationName, type ArchiveAt, type ArchiveId,
  type ArchiveSummary, type ChangedNotes, type Entry, type FindAnswer, type GalleryState, type GroupsAnswer,
  type GroupsAsk, type Looks, nameOf, type NotePatch, type Notes, type Scene, type Series, type SeriesTitle,
  type Table,
} from "./types";

/** Animations per file, in the table's order. */
const ANIMATIONS_PER_FILE = 32;
const ANIMATIONS_BYTES_MAX = 64 * 1024 * 1024;
const SERIES_BYTES_MAX = 64 * 1024 * 1024;
/** Room for one large archive's index: opening another archive drops it. */
const INDEX_BYTES_MAX = 256 * 1024 * 1024;
const PAUSE_MS = 3000;
const NOT_KEPT =
  "Stars and notes last until this page closes, because the browser denies storage to this page.";

/** An answer and its size in bytes. */
interface File {
  readonly packed: Packed;
  readonly bytes: number;
}

interface Searched {
  readonly search: ArchiveSearch;
  /** null if draws weren't counted. */
  readonly satisfied: SatisfiedDraws | null;
  readonly bytes: number;
}

interface Rows {
  readonly table: Table;
  readonly entryOf: ReadonlyMap<AnimationName, Entry>;
}

export interface SavedPlace {
  readonly document: Pick<Document, "createElement" | "head">;
  /** Returns the browser's storage, or throws. */
  readonly storage: () => Storage;
  /** Timeout for loading a file. */
  readonly timeoutMs?: number;
  /** Minimum pause between a failure and the next load. */
  readonly pauseMs?: number;
}

/** REQUIRES: only one instance on the page. */
export function createSavedSource(
  place: SavedPlace = { document, storage: () => localStorage },
): GallerySource {
  return new SavedSource(place);
}

class SavedSource implements GallerySource {
  readonly isLive = false;
  private readonly scripts: SavedScripts;
  private readonly kept: SavedNotes;
  /** Small answers by path. */
  private readonly answers: Once<unknown>;
  private readonly plotted: Once<File>;
  private readonly animated: Once<File>;
  private readonly searched: Once<Searched>;

  constructor(place: SavedPlace) {
    this.scripts = new SavedScripts(place.document, place.timeoutMs);
    this.kept = new SavedNotes(place.storage);
    const pauseMs = place.pauseMs ?? PAUSE_MS;
    const bytesOf = ({ bytes }: { readonly bytes: number }): number => bytes;
    this.answers = new Once({ pauseMs });
    this.plotted = new Once<File>({ pauseMs, bytesOf, bytesMax: SERIES_BYTES_MAX });
    this.animated = new Once<File>({ pauseMs, bytesOf, bytesMax: ANIMATIONS_BYTES_MAX });
    this.searched = new Once<Searched>({ pauseMs, bytesOf, bytesMax: INDEX_BYTES_MAX });
  }

  async gallery(options?: AskOptions): Promise<GalleryState> {
    const state = await this.answer("gallery", async (path) => galleryOf(await this.json(path)), options);
    // The browser decides whether notes are stored.
    const words = this.kept.areKept ? "" : NOT_KEPT;
    return { ...state, notes: { writable: this.kept.areKept, words } };
  }

  scene(archive: ArchiveId, options?: AskOptions): Promise<Scene> {
    return this.answer(`${archive}/scene`, async (path) => sceneOf(await this.json(path)), options);
  }

  looks(archive: ArchiveId, options?: AskOptions): Promise<Looks> {
    return this.answer(`${archive}/looks`, async (path) => looksOf((await this.file(path)).packed), options);
  }

  async table(archive: ArchiveId, options?: AskOptions): Promise<Table> {
    return (await this.rowsOf(archive, options)).table;
  }

  async animations(
    archive: ArchiveId, names: readonly AnimationName[], bodies: number, options?: AskOptions,
  ): Promise<Animation[]> {
    const { entryOf } = await this.rowsOf(archive, options);
    const namesOf = new Map<number, AnimationName[]>();
    for (const name of new Set(names)) {
      const entry = entryOf.get(name);
      if (entry === undefined) throw new SourceError("missing", `There is no animation ${name} in this archive.`);
      const file = Math.floor(entry / ANIMATIONS_PER_FILE);
      namesOf.set(file, [...(namesOf.get(file) ?? []), name]);
    }
    const found = await wanted(
      Promise.all(Array.from(namesOf, ([file, some]) => this.animationsIn(archive, file, some, bodies))),
      options);
    const byName = new Map(found.flat().map((animation) => [animation.name, animation]));
    return names.map((name) => byName.get(name)!);
  }

  async find(
    query: string, archives: readonly ArchiveAt[], options?: AskOptions,
  ): Promise<FindAnswer> {
    const found: { id: ArchiveId; entries: readonly Entry[] }[] = [];
    const errors: { id: ArchiveId; column: number; message: string }[] = [];
    for (const at of archives) {
      const { search } = await this.searchOf(at, options);
      const answer = await search.find(query, options);
      if ("message" in answer) errors.push({ id: at.id, ...answer });
      else found.push({ id: at.id, entries: answer });
    }
    return { found, errors };
  }

  async groups(ask: GroupsAsk, options?: AskOptions): Promise<GroupsAnswer> {
    const { search, satisfied } = await this.searchOf(ask, options);
    const { archives } = await this.gallery(options);
    const { groups, approximate } = await search.groups(ask.entries, ask.groups, ask.by, options);
    const shares = satisfied?.shares(groups.map(({ members }) => members)) ?? null;
    return {
      approximate,
      groups: groups.map((group, i) => ({ ...group, share: shareOf(shares?.[i]) })),
      share_words: groups.length > 0 && shares === null
        ? noShares(archives.find(({ id }) => id === ask.id)) : "",
    };
  }

  async alike(ask: AlikeAsk, options?: AskOptions): Promise<AlikeAnswer> {
    const { search } = await this.searchOf(ask, options);
    return search.alike(ask.to, ask.entries, options);
  }

  seriesTitles(archive: ArchiveId, options?: AskOptions): Promise<SeriesTitle[]> {
    return this.answer(`${archive}/series`, async (path) => seriesTitlesOf(await this.json(path)), options);
  }

  async series(
    archive: ArchiveId, name: string, of: Readonly<Record<string, string>> = {}, options?: AskOptions,
  ): Promise<Series> {
    const chain = of["chain"] ?? "0";
    const path = `${archive}/series-${name}-${chain}`;
    try {
      return seriesOf((await wanted(this.plotted.get(path, () => this.file(path)), options)).packed);
    } catch (error) {
      if (!(error instanceof SourceError) || error.kind !== "missing" || chain === "0") throw error;
      throw new SourceError(
        "missing", `Plots of chain ${chain} are not in this saved gallery.`,
        "Only plots of the first chains were saved; run `sleight gallery` to see all.");
    }
  }

  async diagnosis(archive: ArchiveId, options?: AskOptions): Promise<unknown> {
    const titles = await this.seriesTitles(archive, options);
    if (!titles.some(({ name }) => name === "diagnosis"))
      throw new SourceError("missing", "There are no draws to diagnose.");
    return this.answer(`${archive}/diagnosis`, (path) => this.json(path), options);
  }

  async notes(options?: AskOptions): Promise<Notes> {
    const { archives } = await this.gallery(options);
    return { notes: Object.fromEntries(archives.map(({ run }) => [run, this.kept.ofRun(run)])) };
  }

  async changeNotes(
    run: string, patches: Readonly<Record<AnimationName, NotePatch>>,
  ): Promise<ChangedNotes> {
    const notes = this.kept.change(run, patches);
    return { notes, words: this.kept.areKept ? "" : NOT_KEPT };
  }

  /** Nothing changes: the files are static. */
  onChange(listener: SourceListener): void {
    listener.source("here");
  }

  // ---- Files

  /** REQUIRES: each path has its own type. */
  private answer<T>(path: string, load: (path: string) => Promise<T>, options?: AskOptions): Promise<T> {
    return wanted(this.answers.get(path, () => load(path)) as Promise<T>, options);
  }

  private async json(path: string): Promise<unknown> {
    const { kind, text } = await this.scripts.load(path);
    if (kind !== "json") throw torn(`data/${path}.js is not JSON`);
    try {
      return JSON.parse(text);
    } catch {
      throw torn(`data/${path}.js is not JSON`);
    }
  }

  private async file(path: string): Promise<File> {
    const { kind, text } = await this.scripts.load(path);
    if (kind !== "gz") throw torn(`data/${path}.js is not compressed`);
    const buffer = await unzipped(text);
    return { packed: unpack(buffer), bytes: buffer.byteLength };
  }

  private rowsOf(archive: ArchiveId, options?: AskOptions): Promise<Rows> {
    return this.answer(`${archive}/table`, async (path) => {
      const table = tableOf((await this.file(path)).packed);
      const entryOf = new Map<AnimationName, Entry>();
      for (let entry = 0; entry < table.entries; ++entry) entryOf.set(nameOf(table, entry), entry);
      return { table, entryOf };
    }, options);
  }

  private async animationsIn(
    archive: ArchiveId, file: number, names: readonly AnimationName[], bodies: number,
  ): Promise<Animation[]> {
    const path = `${archive}/animations-${file}`;
    const { packed } = await this.animated.get(path, () => this.file(path));
    return animationsOf(onlyThese(packed, names), bodies);
  }

  private async searchOf({ id, generation }: ArchiveAt, options?: AskOptions): Promise<Searched> {
    const searched = await wanted(this.searched.get(`${id}`, () => this.readIndex(id)), options);
    if (searched.search.generation !== generation)
      throw new SourceError("generation", "The gallery was saved again.", "Reload the page.");
    return searched;
  }

  private async readIndex(id: ArchiveId): Promise<Searched> {
    const { packed, bytes } = await this.file(`${id}/index`);
    return { search: await ArchiveSearch.of(packed), satisfied: SatisfiedDraws.of(packed), bytes };
  }
}

/** Copies the named animations' bytes, so that one animation doesn't keep its whole file in memory. */
function onlyThese(packed: Packed, names: readonly AnimationName[]): Packed {
  const head = packed.head as { readonly animations?: unknown } | null;
  const all: readonly unknown[] = Array.isArray(head?.animations) ? head.animations : [];
  const animations = names.map((name) => {
    const found = all.find((one): one is { name: string; columns: string } => isNamed(one, name));
    if (found === undefined) throw torn(`animation ${name} is missing`);
    return found;
  });
  const prefixes = animations.map(({ columns }) => columns);
  const columns = [...packed.columns].filter(([name]) => prefixes.some((prefix) => name.startsWith(prefix)));
  return { head: { animations }, columns: new Map(columns.map(([name, column]) => [name, column.slice()])) };
}

function isNamed(value: unknown, name: AnimationName): boolean {
  return typeof value === "object" && value !== null && "name" in value && value.name === name &&
    "columns" in value && typeof value.columns === "string";
}

function shareOf(share: Share | undefined): { value: number; error: number | null } | null {
  if (share === undefined) return null;
  return { value: share.value, error: Number.isNaN(share.error) ? null : share.error };
}

/** Why groups have no shares. The first two texts equal the server's. */
function noShares(archive: ArchiveSummary | undefined): string {
  if (archive?.draws === 0)
    return "A search found these animations; their probability in the model is unknown.";
  if (archive?.in_proportion === false) return "The draws are not in the model's proportions.";
  return "No draws can be counted.";
}

/** Rejects when the caller's signal aborts. The load itself continues, because other callers share it. */
function wanted<T>(asked: Promise<T>, options?: AskOptions): Promise<T> {
  const signal = options?.signal;
  if (signal === undefined) return asked;
  return new Promise((resolve, reject) => {
    const aborted = (): void => reject(new SourceError("aborted", "The request was cancelled."));
    if (signal.aborted) aborted();
    signal.addEventListener("abort", aborted, { once: true });
    asked.then(resolve, reject).finally(() => signal.removeEventListener("abort", aborted));
  });
}
