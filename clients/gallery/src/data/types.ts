// Types of a gallery source's answers.
//
// Units are SI. Names ending in `Low`, `High` or `places` are in metres. Meshes have y up, as glTF has. All
// other data are in the scene's frame (right-handed, z up).

import type { Recording } from "../motion/recording";

/** Numbers of one type. */
export type Column = Float64Array | Float32Array | Uint32Array | Int32Array | Uint16Array | Uint8Array;

/** An archive's number; valid while its server runs. */
export type ArchiveId = number;

/** A row of an archive's table, within one generation. */
export type Entry = number;

export type ArchiveState = "ready" | "reading" | "gone" | "damaged";

export interface ArchiveSummary {
  readonly id: ArchiveId;
  readonly name: string;
  /** Outlives servers and generations, so links contain it. */
  readonly run: string;
  readonly generation: number;
  readonly world: string;
  readonly state: ArchiveState;
  /** Reason for the state, for people; may be empty. */
  readonly words: string;
  readonly reading: { readonly done: number; readonly of: number } | null;
  /** Only the archive's first animations have been read; the rest is being read. */
  readonly is_beginning: boolean;
  readonly chains: number;
  readonly draws: number;
  readonly as_of: string;
  readonly warning: string;
  readonly method: string;
  readonly in_proportion: boolean;
  /** The run is in progress, and the gallery follows it. */
  readonly is_live: boolean;
  /** Status of the run, for people. */
  readonly live_words: string;
}

export interface GalleryState {
  readonly archives: readonly ArchiveSummary[];
  readonly left_out: readonly { readonly name: string; readonly reason: string }[];
  readonly notes: { readonly writable: boolean; readonly words: string };
}

export type Place = readonly [number, number, number];

export interface Feature {
  readonly name: string;
  readonly kind: "body" | "fixed" | "wanted";
  /** Radius of a ball around the body's centre that contains the body; 0 for other features. */
  readonly radius_m: number;
}

export interface Scene {
  readonly view_low_m: Place;
  readonly view_high_m: Place;
  /** Bodies come first. */
  readonly features: readonly Feature[];
  readonly numbers: readonly { readonly name: string; readonly unit: string }[];
  /** log_prior of blind throws, ascending; empty if unknown. */
  readonly prior_log_prior: readonly number[];
}

/** Triangles of one material, with y up; bodies are in their own frame. */
export interface Mesh {
  readonly feature: number;
  /** As "#rrggbb". */
  readonly colour: string;
  readonly opacity: number;
  readonly doubleSided: boolean;
  /** Three numbers per vertex. */
  readonly places: Float32Array;
  readonly normals: Float32Array;
  /** Three vertices per triangle, counter-clockwise from outside. */
  readonly corners: Uint32Array;
}

export interface Looks {
  readonly meshes: readonly Mesh[];
}

export interface Table {
  readonly generation: number;
  readonly entries: number;
  readonly isFind: Uint8Array;
  readonly chain: Uint32Array;
  readonly draw: Float64Array;
  readonly inProportion: Uint8Array;
  /** Columns by name; NaN where an animation has no value. */
  readonly numbers: ReadonlyMap<string, Float64Array>;
}

/** "c0.250" (chain 0, draw 250) or "find.3". */
export type AnimationName = string;

export interface Animation {
  readonly name: AnimationName;
  readonly recording: Recording;
  /** Meshes of the features whose look is specific to this animation. */
  readonly meshes: readonly Mesh[];
}

export interface ArchiveAt {
  readonly id: ArchiveId;
  readonly generation: number;
}

export interface FindAnswer {
  readonly found: readonly { readonly id: ArchiveId; readonly entries: readonly Entry[] }[];
  /** `column` counts the query's characters from 1. */
  readonly errors: readonly { readonly id: ArchiveId; readonly column: number; readonly message: string }[];
}

export interface GroupsAsk extends ArchiveAt {
  /** null: all animations. */
  readonly entries: readonly Entry[] | null;
  readonly groups: number;
  readonly by: "medoids" | "hierarchy";
}

export interface Group {
  readonly representative: Entry;
  readonly members: readonly Entry[];
  readonly mean_m: number;
  readonly greatest_m: number;
  /** Share of the satisfied draws; null if draws aren't in proportion. */
  readonly share: { readonly value: number; readonly error: number | null } | null;
}

export interface GroupsAnswer {
  readonly approximate: boolean;
  readonly groups: readonly Group[];
  /** Why there are no shares. */
  readonly share_words: string;
}

export interface AlikeAsk extends ArchiveAt {
  readonly to: readonly Entry[];
  readonly entries: readonly Entry[] | null;
}

export interface AlikeAnswer {
  /** Nearest first. */
  readonly entries: readonly Entry[];
  readonly distance_m: readonly number[];
}

/** A plot that the source offers. */
export interface SeriesTitle {
  readonly name: string;
  readonly title: string;
  readonly kind: string;
  /** Plots of one group are listed together. */
  readonly group: string;
}

/** A plot's data: header and named columns. */
export interface Series {
  readonly head: unknown;
  readonly columns: ReadonlyMap<string, Column>;
}

export interface Note {
  readonly star: boolean;
  readonly hidden: boolean;
  readonly tags: readonly string[];
  readonly note: string;
}

/** Changes to a note. Other people's changes to the same note are kept. */
export interface NotePatch {
  readonly star?: boolean;
  readonly hidden?: boolean;
  readonly note?: string;
  readonly tags_on?: readonly string[];
  readonly tags_off?: readonly string[];
}

/** A stored note; `changed` increases with each change. */
export interface KeptNote extends Note {
  readonly changed: number;
}

/** Notes by run, then by animation name. */
export interface Notes {
  readonly notes: Readonly<Record<string, Readonly<Record<AnimationName, KeptNote>>>>;
}

/** The changed notes, complete. `words`: why notes last no longer than the gallery; "" if they do. */
export interface ChangedNotes {
  readonly notes: Readonly<Record<AnimationName, KeptNote>>;
  readonly words: string;
}

/** The name in its present form: older pages wrote "c0.250" as "0.250". */
export function nameToday(name: string): AnimationName {
  return /^\d/.test(name) ? `c${name}` : name;
}

/** The name of the animation in a table's row. */
export function nameOf(table: Table, entry: Entry): AnimationName {
  const draw = String(table.draw[entry] ?? 0);
  return table.isFind[entry] ? `find.${draw}` : `c${String(table.chain[entry] ?? 0)}.${draw}`;
}
