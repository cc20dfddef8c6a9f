// Where the page has its data from: a server (served.ts), or a saved folder of static files.
//
// Every promise is rejected with a SourceError and with nothing else. A source answers of one
// generation of an archive at a time: the answers name theirs, and questions that hold entries name
// the one they mean.

import type {
  AlikeAnswer, AlikeAsk, Animation, AnimationName, ArchiveAt, ArchiveId, ChangedNotes, FindAnswer,
  GalleryState, GroupsAnswer, GroupsAsk, Looks, NotePatch, Notes, Scene, Series, SeriesTitle, Table,
} from "./types";

export type FailureKind =
  /** The server doesn't answer; it is tried again. */
  | "away"
  /** The server doesn't know this page (any more): its link has to be opened anew. */
  | "refused"
  /** The archive has been read anew: ask for its table again. */
  | "generation"
  /** The archive is still being read: ask again later. */
  | "reading"
  /** There is no such archive, animation or plot. */
  | "missing"
  /** The answer can't be read: torn or not of this version. */
  | "torn"
  /** The caller's signal was aborted. */
  | "aborted"
  /** Anything else that the server says. */
  | "other";

export class SourceError extends Error {
  override readonly name = "SourceError";
  constructor(
    readonly kind: FailureKind,
    message: string,
    /** A sentence for people; may be empty. */
    readonly whatToDo = "",
  ) {
    super(message);
  }
}

/** How the source is: "away" while it tries to reach its server again. */
export type SourceState = "here" | "away" | "refused";

export interface SourceListener {
  /** Something in the gallery has changed. */
  gallery(state: GalleryState): void;
  /** Called once at once, then at each change. */
  source(state: SourceState): void;
}

export interface AskOptions {
  readonly signal?: AbortSignal;
  /** The browser sends it even where the page goes away at once; nobody may read the answer then. */
  readonly outlivesPage?: boolean;
}

/** Most names in one question: animations() splits what is longer. */
export const ANIMATIONS_PER_ASK = 32;

export interface GallerySource {
  /** Whether there is a server, so that runs grow and notes can be kept. */
  readonly isLive: boolean;
  gallery(options?: AskOptions): Promise<GalleryState>;
  scene(archive: ArchiveId, options?: AskOptions): Promise<Scene>;
  looks(archive: ArchiveId, options?: AskOptions): Promise<Looks>;
  table(archive: ArchiveId, options?: AskOptions): Promise<Table>;
  /** In the order of the names. `bodies`: how many the scene has. */
  animations(
    archive: ArchiveId, names: readonly AnimationName[], bodies: number, options?: AskOptions,
  ): Promise<Animation[]>;
  /** An empty query finds all. */
  find(query: string, archives: readonly ArchiveAt[], options?: AskOptions): Promise<FindAnswer>;
  groups(ask: GroupsAsk, options?: AskOptions): Promise<GroupsAnswer>;
  alike(ask: AlikeAsk, options?: AskOptions): Promise<AlikeAnswer>;
  seriesTitles(archive: ArchiveId, options?: AskOptions): Promise<SeriesTitle[]>;
  /** `of` are the question's parameters, such as {chain: "0"}. */
  series(
    archive: ArchiveId, name: string, of?: Readonly<Record<string, string>>, options?: AskOptions,
  ): Promise<Series>;
  /** As `sleight diagnose --json` says it. */
  diagnosis(archive: ArchiveId, options?: AskOptions): Promise<unknown>;
  notes(options?: AskOptions): Promise<Notes>;
  /** Changes some notes of a run: all of them or none. */
  changeNotes(
    run: string, patches: Readonly<Record<AnimationName, NotePatch>>, options?: AskOptions,
  ): Promise<ChangedNotes>;
  /** Returns what ends it. */
  onChange(listener: SourceListener): () => void;
}
