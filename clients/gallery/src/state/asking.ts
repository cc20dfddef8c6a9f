// Requests the answers that the state needs and lacks from the source: query answers, groups and distances.
// Each change of the state is checked. Answers that are out of date are dropped.
import { noteOf } from "../data/note-patch";
import { SourceError, type GallerySource } from "../data/source";
import { noEntries, type AppState, type Loaded, type QueryAnswer, type ShownGroups } from "./app-state";
import { areGroupsThere, within } from "./derived";
import { ascending, intersection, type Entries } from "./entry-sets";
import { say, sentenceOf } from "./messages";
import { isLetThrough } from "./notes";
import type { PathStep } from "./page";
import { Latest, type Store } from "./store";

/** Maximum number of cached answers. */
const answersMax = 300;
const groupsDelayMs = 60;

/** Requests one query's answer for one generation. */
export async function askFind(source: GallerySource, loaded: Loaded, text: string): Promise<QueryAnswer> {
  const answer = await source.find(text, [{ id: loaded.id, generation: loaded.generation }]);
  const error = answer.errors.find(({ id }) => id === loaded.id);
  if (error !== undefined) return { entries: null, error: { column: error.column, message: error.message } };
  const found = answer.found.find(({ id }) => id === loaded.id);
  return { entries: ascending(found?.entries ?? []), error: null };
}

export class Asking {
  private readonly inFlight = new Set<string>();
  private readonly groupsAsk = new Latest();
  private readonly alikeAsk = new Latest();
  private groupsTimer: ReturnType<typeof setTimeout> | undefined;
  private groupsKey: readonly unknown[] = [];
  private alikeKey: readonly unknown[] = [];
  private openingKey: readonly unknown[] = [];

  constructor(
    private readonly store: Store<AppState>,
    private readonly source: GallerySource,
    /** Called when an answer reports that the archive was read again. */
    private readonly lookAgain: () => void,
  ) {}

  start(): void {
    this.store.subscribe((state) => this.look(state));
  }

  private look(state: AppState): void {
    const { loaded } = state;
    if (loaded === null || state.source !== "here") return;
    for (const text of textsOf(state)) if (!state.answers.has(text)) void this.find(loaded, text);
    this.lookAtPath(state, loaded);
    this.lookAtGroups(state, loaded);
    this.lookAtDistances(state, loaded);
  }

  private async find(loaded: Loaded, text: string): Promise<void> {
    const key = `${loaded.id} ${loaded.generation} ${text}`;
    if (this.inFlight.has(key)) return;
    this.inFlight.add(key);
    try {
      const answer = await askFind(this.source, loaded, text);
      if (this.store.state.loaded !== loaded) return;
      this.keep(text, answer);
    } catch (error) {
      // Without a stored answer, each change of the state would repeat the request.
      if (!mayPass(error) && this.store.state.loaded === loaded) this.keep(text, { entries: null, error: null });
      this.failed(error);
    } finally {
      this.inFlight.delete(key);
    }
  }

  private keep(text: string, answer: QueryAnswer): void {
    const answers = new Map(this.store.state.answers).set(text, answer);
    this.store.set({
      answers: answers.size > answersMax ? pruned(answers, textsOf(this.store.state)) : answers,
    });
  }

  // Groups

  private lookAtGroups(state: AppState, loaded: Loaded): void {
    if (state.page.view !== "groups" || state.opened.includes(null) || !areAnswered(state)) return;
    const of = within(state);
    if (areGroupsThere(state)) return;
    const { groups, by } = state.page.grouping;
    const key = [loaded, of, groups, by];
    if (key.every((part, i) => part === this.groupsKey[i])) return;
    this.groupsKey = key;
    const isWanted = this.groupsAsk.begin();
    clearTimeout(this.groupsTimer);
    this.groupsTimer = setTimeout(
      () => void this.group(loaded, of, state.page.grouping, isWanted),
      // Request the first groups without delay, because a person waits for them.
      state.groups === null ? 0 : groupsDelayMs,
    );
  }

  private async group(
    loaded: Loaded,
    of: Entries,
    ask: ShownGroups["ask"],
    isWanted: () => boolean,
  ): Promise<void> {
    try {
      const groups = await this.askGroups(loaded, of, ask);
      if (isWanted() && this.store.state.loaded === loaded) this.store.set({ groups, groupsFailure: "" });
    } catch (error) {
      if (!isWanted()) return;
      if (mayPass(error)) this.groupsKey = [];
      this.failed(error);
      if (isOfServer(error)) this.store.set({ groupsFailure: sentenceOf(error) });
    }
  }

  private async askGroups(loaded: Loaded, of: Entries, ask: ShownGroups["ask"]): Promise<ShownGroups> {
    const base = { of, ask: { groups: ask.groups, by: ask.by } };
    if (of.length === 0) return { ...base, list: [], isApproximate: false, shareWords: "" };
    const answer = await this.source.groups({
      id: loaded.id,
      generation: loaded.generation,
      entries: of.length === loaded.names.length ? null : Array.from(of),
      groups: Math.min(ask.groups, of.length),
      by: ask.by,
    });
    const list = answer.groups
      .map((group) => ({ ...group, members: ascending(group.members) }))
      .sort((a, b) => b.members.length - a.members.length);
    return { ...base, list, isApproximate: answer.approximate, shareWords: answer.share_words };
  }

  // Open groups from a link

  private lookAtPath(state: AppState, loaded: Loaded): void {
    const depth = state.opened.indexOf(null);
    const step = state.page.path[depth];
    if (depth < 0 || step === undefined) return;
    const answer = step.query === "" ? { entries: state.visible } : state.answers.get(step.query);
    if (answer === undefined) return;
    const key = [loaded, step, state.opened[depth - 1]];
    if (key.every((part, i) => part === this.openingKey[i])) return;
    this.openingKey = key;
    let of: Entries = intersection(state.visible, answer.entries ?? noEntries).filter((entry) =>
      isLetThrough(noteOf(state.notes, loaded.names[entry] ?? ""), state.page.notesFilter),
    );
    for (const members of state.opened.slice(0, depth)) of = intersection(of, members ?? noEntries);
    void this.open(loaded, of, step, depth);
  }

  private async open(loaded: Loaded, of: Entries, step: PathStep, depth: number): Promise<void> {
    try {
      const groups = await this.askGroups(loaded, of, step);
      const { state } = this.store;
      if (state.page.path[depth] !== step || state.loaded !== loaded) return;
      const representative = loaded.entryOf.get(step.representative) ?? -1;
      const group = groups.list.find(({ members }) => members.includes(representative));
      if (group !== undefined) {
        const opened = state.opened.map((entries, i) => (i === depth ? group.members : entries));
        this.store.set({ opened });
        return;
      }
      say(this.store, `There is no group of ${step.representative}. The enclosing groups are shown instead.`);
      this.store.set({
        page: { ...state.page, path: state.page.path.slice(0, depth) },
        opened: state.opened.slice(0, depth),
      });
    } catch (error) {
      if (mayPass(error)) this.openingKey = [];
      this.failed(error);
    }
  }

  // Distances for sorting by likeness

  private lookAtDistances(state: AppState, loaded: Loaded): void {
    const { sort } = state.page;
    const isThere = state.distances?.generation === loaded.generation;
    if (sort.by !== "alike" || (isThere && state.distances.to === sort.to)) return;
    const key = [loaded, sort.to];
    if (key.every((part, i) => part === this.alikeKey[i])) return;
    this.alikeKey = key;
    void this.measure(loaded, sort.to, this.alikeAsk.begin());
  }

  private async measure(loaded: Loaded, to: readonly string[], isWanted: () => boolean): Promise<void> {
    const entries = to.map((name) => loaded.entryOf.get(name)).filter((entry) => entry !== undefined);
    const byEntry = new Float64Array(loaded.names.length).fill(NaN);
    if (entries.length === 0) {
      this.store.set({ distances: { to, byEntry, generation: loaded.generation } });
      return;
    }
    try {
      const answer = await this.source.alike({
        id: loaded.id,
        generation: loaded.generation,
        to: entries,
        entries: null,
      });
      if (!isWanted() || this.store.state.loaded !== loaded) return;
      answer.entries.forEach((entry, i) => {
        byEntry[entry] = answer.distance_m[i] ?? NaN;
      });
      this.store.set({ distances: { to, byEntry, generation: loaded.generation } });
    } catch (error) {
      if (mayPass(error)) this.alikeKey = [];
      this.failed(error);
    }
  }

  private failed(error: unknown): void {
    if (!(error instanceof SourceError)) throw error;
    if (error.kind === "generation" || error.kind === "reading") this.lookAgain();
    else if (isOfServer(error)) say(this.store, sentenceOf(error));
  }
}

/** Whether the same request may succeed later. Other requests are repeated only after a change. */
function mayPass(error: unknown): boolean {
  return !(error instanceof SourceError && (error.kind === "missing" || error.kind === "other"));
}

/** Whether the error needs a message here. "away", "refused" and "aborted" are reported elsewhere. */
function isOfServer(error: unknown): boolean {
  return error instanceof SourceError && ["missing", "torn", "other"].includes(error.kind);
}

/** All queries that the page needs. */
function textsOf(state: AppState): Set<string> {
  const texts = new Set(state.page.chips.map(({ text }) => text));
  for (const { query } of state.page.path) if (query !== "") texts.add(query);
  for (const text of [state.draft, state.built]) if (text !== "") texts.add(text);
  return texts;
}

function areAnswered(state: AppState): boolean {
  return state.page.chips.every((chip) => !chip.isOn || state.answers.has(chip.text));
}

function pruned(
  answers: ReadonlyMap<string, QueryAnswer>,
  wanted: ReadonlySet<string>,
): Map<string, QueryAnswer> {
  return new Map([...answers].filter(([text], i) => wanted.has(text) || i > answers.size - answersMax / 2));
}
