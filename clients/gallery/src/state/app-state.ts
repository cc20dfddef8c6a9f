// The page's whole state: what links contain (`page`), the source's answers, and activities in progress.
import type { NotesByName } from "../data/note-patch";
import type { SourceState } from "../data/source";
import type { ArchiveId, ArchiveSummary, GalleryState, GroupsAsk, Looks, NotePatch, Scene, Table } from "../data/types";
import type { Range } from "./conditions";
import type { Entries } from "./entry-sets";
import type { Chip, DrawnBox, Page } from "./page";
import type { Selection } from "./selection";
import type { History } from "./undo";

/** One generation of one archive. */
export interface Loaded {
  readonly id: ArchiveId;
  readonly run: string;
  readonly generation: number;
  /** The archive's summary at the time of loading. */
  readonly archive: ArchiveSummary;
  readonly scene: Scene;
  readonly looks: Looks;
  readonly table: Table;
  /** Names by entry. */
  readonly names: readonly string[];
  readonly entryOf: ReadonlyMap<string, number>;
  /** Number of bodies, which are the first features. */
  readonly bodies: number;
}

/** The animations that match a query's text. */
export interface QueryAnswer {
  /** null: not answered yet, or the query is invalid. */
  readonly entries: Entries | null;
  readonly error: { readonly column: number; readonly message: string } | null;
}

export interface ShownGroup {
  readonly representative: number;
  readonly members: Entries;
  readonly mean_m: number;
  readonly share: { readonly value: number; readonly error: number | null } | null;
}

export interface ShownGroups {
  /** The entries that were grouped, and how; compared to find out whether groups are out of date. */
  readonly of: Entries;
  readonly ask: Pick<GroupsAsk, "groups" | "by">;
  readonly list: readonly ShownGroup[];
  readonly isApproximate: boolean;
  readonly shareWords: string;
}

export interface Distances {
  readonly to: readonly string[];
  readonly byEntry: Float64Array;
  /** Generation of the distances. Entries that are newer have no distance yet. */
  readonly generation: number;
}

/** What undo restores: notes by name, or the chips. */
export type Undoable =
  | { readonly kind: "notes"; readonly run: string; readonly notes: Readonly<Record<string, NotePatch>> }
  | { readonly kind: "chips"; readonly chips: readonly Chip[] };

/** A message of the page. The same words again are a new message. */
export interface Message {
  readonly words: string;
  readonly number: number;
}

export interface AppState {
  readonly page: Page;
  readonly selection: Selection;
  readonly gallery: GalleryState | null;
  readonly source: SourceState;
  readonly loaded: Loaded | null;
  /** Why nothing can be shown; "" if loading succeeded or is in progress. */
  readonly loadFailure: string;
  /** Entries that are shown. New entries stay hidden until a person requests them. */
  readonly visible: Entries;
  readonly asOf: string;
  /** The entries are the archive's first animations; the others are old too, but read later. */
  readonly isBeginning: boolean;
  readonly answers: ReadonlyMap<string, QueryAnswer>;
  /** The query being typed, and the query being built; "": none. */
  readonly draft: string;
  readonly built: string;
  readonly notes: NotesByName;
  readonly notesWords: string;
  /** The browser has no WebGL. */
  readonly hasNoPictures: boolean;
  readonly history: History<Undoable>;
  readonly groups: ShownGroups | null;
  readonly groupsFailure: string;
  /** Members of the groups in page.path; null: not loaded yet. */
  readonly opened: readonly (Entries | null)[];
  /** Distances to the animations of page.sort; null: not loaded yet. */
  readonly distances: Distances | null;
  readonly message: Message;
  /** What a person shall draw in the player for the builder. */
  readonly drawing: { readonly box: boolean; readonly time: boolean };
  readonly drawnBox: DrawnBox | null;
  readonly drawnRange: Range | null;
}

export const noEntries: Entries = new Uint32Array(0);
