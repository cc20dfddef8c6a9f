// A gallery answered by a server: `sleight gallery`.
//
// While the server doesn't answer, the listener is notified, and requests wait until the server answers; then
// they are sent again. Only changeNotes() doesn't wait. The event stream shows whether the server answers. A
// broken stream is opened again with increasing pauses, so nobody has to reload the page.

import {
  animationsOf, galleryOf, looksOf, sceneOf, seriesOf, seriesTitlesOf, tableOf,
} from "./decode";
import { isObject, type Packed, torn, unpack } from "./packed";
import {
  type AskOptions, type FailureKind, type GallerySource, SourceError,
  type SourceListener, type SourceState,
} from "./source";
import type {
  AlikeAnswer, AlikeAsk, Animation, AnimationName, ArchiveAt, ArchiveId, ChangedNotes, FindAnswer,
  GalleryState, GroupsAnswer, GroupsAsk, Looks, NotePatch, Notes, Scene, Series, SeriesTitle, Table,
} from "./types";

const PAUSE_MS_MIN = 250;
const PAUSE_MS_MAX = 4000;
const AWAY = new SourceError(
  "away", "The gallery's server doesn't answer.", "The page reconnects automatically; nothing is lost.");
const ABORTED = new SourceError("aborted", "The request was cancelled.");

/** `base`: the page's address. */
export function createServedSource(base: string = document.baseURI): GallerySource {
  return new ServedSource(base);
}

interface Question {
  readonly path: string;
  /** A POST request's body, sent as JSON. */
  readonly body?: unknown;
  /** Whether the request waits while the server doesn't answer. */
  readonly waits: boolean;
}

class ServedSource implements GallerySource {
  readonly isLive = true;
  private state: SourceState = "here";
  private listener: SourceListener | null = null;
  private stream: EventSource | null = null;
  private timer: ReturnType<typeof setTimeout> | null = null;
  private pauseMs = PAUSE_MS_MIN;
  /** Requests that wait for the server. */
  private readonly waiting = new Set<() => void>();

  constructor(private readonly base: string) {}

  async gallery(options?: AskOptions): Promise<GalleryState> {
    return galleryOf(await this.json({ path: "gallery", waits: true }, options));
  }
  async scene(archive: ArchiveId, options?: AskOptions): Promise<Scene> {
    return sceneOf(await this.json({ path: `archives/${archive}/scene`, waits: true }, options));
  }
  async looks(archive: ArchiveId, options?: AskOptions): Promise<Looks> {
    return looksOf(await this.packed({ path: `archives/${archive}/looks`, waits: true }, options));
  }
  async table(archive: ArchiveId, options?: AskOptions): Promise<Table> {
    return tableOf(await this.packed({ path: `archives/${archive}/table`, waits: true }, options));
  }

  async animations(
    archive: ArchiveId, names: readonly AnimationName[], bodies: number, options?: AskOptions,
  ): Promise<Animation[]> {
    const path = `archives/${archive}/animations?names=${names.map(encodeURIComponent).join(",")}`;
    return animationsOf(await this.packed({ path, waits: true }, options), bodies);
  }

  async find(
    query: string, archives: readonly ArchiveAt[], options?: AskOptions,
  ): Promise<FindAnswer> {
    const answer = await this.json({ path: "find", body: { query, archives }, waits: true }, options);
    return withLists<FindAnswer>(answer, "found", "errors");
  }
  async groups(ask: GroupsAsk, options?: AskOptions): Promise<GroupsAnswer> {
    return withLists<GroupsAnswer>(await this.json({ path: "groups", body: ask, waits: true }, options),
      "groups");
  }
  async alike(ask: AlikeAsk, options?: AskOptions): Promise<AlikeAnswer> {
    return withLists<AlikeAnswer>(await this.json({ path: "alike", body: ask, waits: true }, options),
      "entries", "distance_m");
  }
  async seriesTitles(archive: ArchiveId, options?: AskOptions): Promise<SeriesTitle[]> {
    return seriesTitlesOf(await this.json({ path: `archives/${archive}/series`, waits: true }, options));
  }
  async series(
    archive: ArchiveId, name: string, of: Readonly<Record<string, string>> = {}, options?: AskOptions,
  ): Promise<Series> {
    const parameters = new URLSearchParams(of).toString();
    const path = `archives/${archive}/series/${encodeURIComponent(name)}${parameters && `?${parameters}`}`;
    return seriesOf(await this.packed({ path, waits: true }, options));
  }
  async diagnosis(archive: ArchiveId, options?: AskOptions): Promise<unknown> {
    return this.json({ path: `archives/${archive}/diagnosis`, waits: true }, options);
  }
  async notes(options?: AskOptions): Promise<Notes> {
    const answer = await this.json({ path: "notes", waits: true }, options);
    if (!isObject(answer) || !isObject(answer["notes"])) throw torn("'notes' is missing");
    return answer as unknown as Notes;
  }
  async changeNotes(
    run: string, patches: Readonly<Record<AnimationName, NotePatch>>, options?: AskOptions,
  ): Promise<ChangedNotes> {
    const answer = await this.json({ path: "notes", body: { run, notes: patches }, waits: false }, options);
    if (!isObject(answer) || !isObject(answer["notes"])) throw torn("'notes' is missing");
    return answer as unknown as ChangedNotes;
  }

  onChange(listener: SourceListener): void {
    this.listener = listener;
    listener.source(this.state);
    if (this.stream === null && this.timer === null) this.listen();
  }

  // ---- Requests

  private async json(question: Question, options: AskOptions | undefined): Promise<unknown> {
    return this.ask(question, options, async (response) => {
      const text = await response.text();
      try {
        return JSON.parse(text) as unknown;
      } catch {
        throw torn("the answer is not JSON");
      }
    });
  }

  private async packed(question: Question, options: AskOptions | undefined): Promise<Packed> {
    return this.ask(question, options, async (response) => unpack(await response.arrayBuffer()));
  }

  /** Sends the request, and repeats it when the server returns, until it is answered or cancelled. */
  private async ask<T>(
    question: Question, options: AskOptions | undefined, read: (response: Response) => Promise<T>,
  ): Promise<T> {
    const signal = options?.signal;
    for (;;) {
      if (signal?.aborted) throw ABORTED;
      try {
        const response = await fetch(new URL(`api/${question.path}`, this.base), initOf(question, options));
        if (!response.ok) throw await failureOf(response);
        return await read(response);
      } catch (error) {
        if (signal?.aborted) throw ABORTED;
        // All other errors are network errors: fetch() failed or the body broke off.
        if (error instanceof SourceError) {
          if (error.kind === "refused") this.lost("refused");
          throw error;
        }
        this.lost("away");
        if (!question.waits) throw AWAY;
        await this.back(signal);
      }
    }
  }

  /** Resolves when the server answers again. */
  private back(signal: AbortSignal | undefined): Promise<void> {
    return new Promise((resolve, reject) => {
      const done = (): void => {
        this.waiting.delete(done);
        signal?.removeEventListener("abort", aborted);
        resolve();
      };
      const aborted = (): void => {
        this.waiting.delete(done);
        reject(ABORTED);
      };
      signal?.addEventListener("abort", aborted, { once: true });
      this.waiting.add(done);
    });
  }

  // ---- Connection to the server

  private listen(): void {
    this.timer = null;
    const stream = new EventSource(new URL("api/events", this.base));
    this.stream = stream;
    stream.addEventListener("gallery", (event) => this.changed(event));
    stream.onopen = () => this.found();
    stream.onerror = () => {
      // Close the stream, because the browser's own retries neither report refusals nor back off.
      stream.close();
      if (this.stream !== stream) return;
      this.stream = null;
      void this.probe();
    };
  }

  /** Finds out why the stream broke, because the stream doesn't report it. */
  private async probe(): Promise<void> {
    try {
      const response = await fetch(new URL("api/gallery", this.base), { cache: "no-store" });
      if (response.ok) {
        // The server answers; only the stream broke.
        this.listener?.gallery(galleryOf(await response.json()));
        this.found();
      } else {
        this.lost((await failureOf(response)).kind === "refused" ? "refused" : "away");
      }
    } catch {
      this.lost("away");
    }
    this.again();
  }

  private again(): void {
    if (this.stream !== null || this.timer !== null) return;
    this.timer = setTimeout(() => this.listen(), this.pauseMs);
    this.pauseMs = Math.min(2 * this.pauseMs, PAUSE_MS_MAX);
  }

  private found(): void {
    if (this.stream !== null) this.pauseMs = PAUSE_MS_MIN;
    this.become("here");
    for (const done of [...this.waiting]) done();
  }

  private lost(state: "away" | "refused"): void {
    this.become(state);
    // Open a new stream, which reports when the server returns.
    this.stream?.close();
    this.stream = null;
    this.again();
  }

  private become(state: SourceState): void {
    if (state === this.state) return;
    this.state = state;
    this.listener?.source(state);
  }

  private changed(event: Event): void {
    if (!(event instanceof MessageEvent) || typeof event.data !== "string") return;
    try {
      this.listener?.gallery(galleryOf(JSON.parse(event.data)));
    } catch {
      // Ignore an invalid event: the next event contains the whole state again.
    }
  }
}

function initOf(question: Question, options: AskOptions | undefined): RequestInit {
  const init: RequestInit = { cache: "no-store", keepalive: options?.outlivesPage ?? false };
  if (options?.signal !== undefined) init.signal = options.signal;
  if (question.body === undefined) return init;
  return {
    ...init,
    method: "POST",
    headers: { "content-type": "application/json" },
    body: JSON.stringify(question.body),
  };
}

async function failureOf(response: Response): Promise<SourceError> {
  let said: unknown = null;
  try {
    said = await response.json();
  } catch {
    // The response body isn't our JSON (from a proxy, for example): use the status alone.
  }
  const error = isObject(said) && typeof said["error"] === "string" ? said["error"] : "";
  const toDo = isObject(said) && typeof said["what_to_do"] === "string" ? said["what_to_do"] : "";
  return new SourceError(
    kindOf(response.status), error || `The server returned HTTP status ${response.status}.`, toDo);
}

function kindOf(status: number): FailureKind {
  switch (status) {
    case 401: case 403: return "refused";
    case 404: return "missing";
    case 409: return "generation";
    case 503: return "reading";
    default: return "other";
  }
}

/** Checks that the answer's named fields are lists. */
function withLists<T>(answer: unknown, ...lists: readonly (keyof T & string)[]): T {
  if (!isObject(answer)) throw torn("the answer is not an object");
  for (const list of lists) if (!Array.isArray(answer[list])) throw torn(`the answer has no list '${list}'`);
  return answer as unknown as T;
}
