// All that the page knows: what the link holds (`page`), what the source has answered, and what is
// being done at the moment.
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
  /** What was said of it then. */
  readonly archive: ArchiveSummary;
  readonly scene: Scene;
  readonly looks: Looks;
  readonly table: Table;
  /** By entry. */
  readonly names: readonly string[];
  readonly entryOf: ReadonlyMap<string, number>;
  /** How many features are bodies: the first ones. */
  readonly bodies: number;
}

/** What a query's text is true of. */
export interface QueryAnswer {
  /** null: not answered yet, or the text is wrong. */
  readonly entries: Entries | null;
  readonly error: { readonly column: number; readonly message: string } | null;
}

export interface ShownGroup {
  readonly representative: number;
  readonly members: Entries;
  readonly mean_m: number;
  readonly greatest_m: number;
  readonly share: { readonly value: number; readonly error: number | null } | null;
}

export interface ShownGroups {
  /** Of which entries, into how many and how (to know whether it is to be asked again). */
  readonly of: Entries;
  readonly ask: Pick<GroupsAsk, "groups" | "by">;
  readonly list: readonly ShownGroup[];
  readonly isApproximate: boolean;
  readonly shareWords: string;
}

export interface Distances {
  readonly to: readonly string[];
  readonly byEntry: Float64Array;
  /** Measured of this generation; of an earlier one: what is new in this one has none yet. */
  readonly generation: number;
}

/** What undo puts back: notes by name, or the chips. */
export type Undoable =
  | { readonly kind: "notes"; readonly run: string; readonly notes: Readonly<Record<string, NotePatch>> }
  | { readonly kind: "chips"; readonly chips: readonly Chip[] };

/** A sentence of the page; the same words again are another message. */
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
  /** Why there is nothing to show; "" where there is, or while it is being loaded. */
  readonly loadFailure: string;
  /** Entries that are shown: those that have come since wait until they are asked for. */
  readonly visible: Entries;
  readonly asOf: string;
  /** They are an archive's beginning: what waits was there before, and has been read since. */
  readonly isBeginning: boolean;
  readonly answers: ReadonlyMap<string, QueryAnswer>;
  /** The query that is being written, and the one that is being built; "": none. */
  readonly draft: string;
  readonly built: string;
  readonly notes: NotesByName;
  readonly notesWords: string;
  /** The browser has no WebGL. */
  readonly hasNoPictures: boolean;
  readonly history: History<Undoable>;
  readonly groups: ShownGroups | null;
  readonly groupsFailure: string;
  /** Members of the groups of page.path, once they are known. */
  readonly opened: readonly (Entries | null)[];
  /** Distances of entries to those of page.sort; null while they are not known. */
  readonly distances: Distances | null;
  readonly message: Message;
  /** What the player is asked to let a person draw for the builder. */
  readonly drawing: { readonly box: boolean; readonly time: boolean };
  readonly drawnBox: DrawnBox | null;
  readonly drawnRange: Range | null;
}

export const noEntries: Entries = new Uint32Array(0);
