// The source of the page's data: a server (served.ts) or a saved folder of static files (saved.ts).
//
// Promises reject only with SourceError. A source answers for one generation of an archive at a time. So each
// answer contains a generation, and each request with entries contains the entries' generation.

import type {
  AlikeAnswer, AlikeAsk, Animation, AnimationName, ArchiveAt, ArchiveId, ChangedNotes, FindAnswer,
  GalleryState, GroupsAnswer, GroupsAsk, Looks, NotePatch, Notes, Scene, Series, SeriesTitle, Table,
} from "./types";

export type FailureKind =
  /** The server doesn't answer; the source retries. */
  | "away"
  /** The server doesn't accept this page (any more): the person must open the server's link again. */
  | "refused"
  /** The archive was read again: request its table again. */
  | "generation"
  /** The archive is still being read: retry later. */
  | "reading"
  /** The archive, animation or plot doesn't exist. */
  | "missing"
  /** The answer is invalid: truncated, or from another version. */
  | "torn"
  /** The caller's signal was aborted. */
  | "aborted"
  /** Any other error from the server. */
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

/** State of the source. "away": it tries to reach its server again. */
export type SourceState = "here" | "away" | "refused";

export interface SourceListener {
  /** Called when something in the gallery has changed. */
  gallery(state: GalleryState): void;
  /** Called at once, then at each change. */
  source(state: SourceState): void;
}

export interface AskOptions {
  readonly signal?: AbortSignal;
  /** The browser sends the request even if the page closes; nobody may read the answer then. */
  readonly outlivesPage?: boolean;
}

export interface GallerySource {
  /** Whether there is a server, so that archives can change. */
  readonly isLive: boolean;
  gallery(options?: AskOptions): Promise<GalleryState>;
  scene(archive: ArchiveId, options?: AskOptions): Promise<Scene>;
  looks(archive: ArchiveId, options?: AskOptions): Promise<Looks>;
  table(archive: ArchiveId, options?: AskOptions): Promise<Table>;
  /** Returns animations in the order of the names, which are at most 32. `bodies`: number of bodies in the
   *  scene. */
  animations(
    archive: ArchiveId, names: readonly AnimationName[], bodies: number, options?: AskOptions,
  ): Promise<Animation[]>;
  /** An empty query matches all animations. */
  find(query: string, archives: readonly ArchiveAt[], options?: AskOptions): Promise<FindAnswer>;
  groups(ask: GroupsAsk, options?: AskOptions): Promise<GroupsAnswer>;
  alike(ask: AlikeAsk, options?: AskOptions): Promise<AlikeAnswer>;
  seriesTitles(archive: ArchiveId, options?: AskOptions): Promise<SeriesTitle[]>;
  /** `of`: the request's parameters, such as {chain: "0"}. */
  series(
    archive: ArchiveId, name: string, of?: Readonly<Record<string, string>>, options?: AskOptions,
  ): Promise<Series>;
  /** The diagnosis, as `sleight diagnose --json` prints it. */
  diagnosis(archive: ArchiveId, options?: AskOptions): Promise<unknown>;
  notes(options?: AskOptions): Promise<Notes>;
  /** Changes some notes of a run: all of them or none. */
  changeNotes(
    run: string, patches: Readonly<Record<AnimationName, NotePatch>>, options?: AskOptions,
  ): Promise<ChangedNotes>;
  /** REQUIRES: called only once. */
  onChange(listener: SourceListener): void;
}
