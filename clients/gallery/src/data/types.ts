// What a gallery's source answers, as the page holds it.
//
// Units are SI; names that end in `Low`, `High` or `places` are metres. Frames: everything but
// meshes is in the scene's own frame (right-handed, z up); meshes have y up, as glTF has.

import type { Recording } from "../motion/recording";

/** Numbers of one kind, tightly packed. */
export type Column = Float64Array | Float32Array | Uint32Array | Int32Array | Uint16Array | Uint8Array;

/** An archive's number, for as long as its server runs. */
export type ArchiveId = number;

/** A row of an archive's table, of one generation. */
export type Entry = number;

export type ArchiveState = "ready" | "reading" | "gone" | "damaged";

export interface ArchiveSummary {
  readonly id: ArchiveId;
  readonly name: string;
  /** Outlives servers and generations: links hold it. */
  readonly run: string;
  readonly generation: number;
  readonly world: string;
  readonly state: ArchiveState;
  /** Why, for people; empty where there is nothing to say. */
  readonly words: string;
  readonly reading: { readonly done: number; readonly of: number } | null;
  readonly kept: number;
  readonly finds: number;
  /** Kept and finds are those of the archive's beginning: the rest is being read. */
  readonly is_beginning: boolean;
  readonly keep_max: number;
  readonly chains: number;
  readonly draws: number;
  readonly scans: number;
  readonly as_of: string;
  readonly warning: string;
  readonly method: string;
  readonly in_proportion: boolean;
  readonly satisfied: { readonly draws: number; readonly of: number } | null;
  /** Its run goes on, and is followed. */
  readonly is_live: boolean;
  /** How that run stands, for people. */
  readonly live_words: string;
}

export interface GalleryState {
  readonly version: string;
  readonly archives: readonly ArchiveSummary[];
  readonly left_out: readonly { readonly name: string; readonly reason: string }[];
  readonly notes: { readonly writable: boolean; readonly words: string };
}

export type Place = readonly [number, number, number];

export interface Feature {
  readonly name: string;
  readonly kind: "body" | "fixed" | "wanted";
  readonly twin_of: number;
  /** The body that a wanted place is meant for; -1: none, or any. */
  readonly body: number;
  /** Of a ball about the body's centre that holds it; 0 of all else. */
  readonly radius_m: number;
}

export interface Scene {
  readonly generation: number;
  readonly view_low_m: Place;
  readonly view_high_m: Place;
  readonly offsets: boolean;
  /** Bodies come first. */
  readonly features: readonly Feature[];
  readonly numbers: readonly { readonly name: string; readonly unit: string }[];
  /** Of blind throws, ascending; empty: not known. */
  readonly prior_log_prior: readonly number[];
  readonly request: string;
}

/** Triangles of one material; y up; of bodies in the body's frame. */
export interface Mesh {
  readonly feature: number;
  /** "#rrggbb". */
  readonly colour: string;
  readonly opacity: number;
  readonly doubleSided: boolean;
  /** Three numbers to a vertex. */
  readonly places: Float32Array;
  readonly normals: Float32Array;
  /** Three vertices to a triangle, counter-clockwise from outside. */
  readonly corners: Uint32Array;
}

export interface Looks {
  readonly generation: number;
  readonly meshes: readonly Mesh[];
  /** Features whose look is an animation's own. */
  readonly own: readonly number[];
}

export interface Table {
  readonly generation: number;
  readonly entries: number;
  readonly isFind: Uint8Array;
  readonly chain: Uint32Array;
  readonly draw: Float64Array;
  readonly inProportion: Uint8Array;
  readonly endS: Float64Array;
  readonly lineage: Float64Array;
  /** By name; NaN: that animation has none. */
  readonly numbers: ReadonlyMap<string, Float64Array>;
}

/** "c0.250" (chain 0, draw 250) or "find.3". */
export type AnimationName = string;

export interface Animation {
  readonly name: AnimationName;
  readonly endS: number;
  readonly recording: Recording;
  /** Of the features whose look is this animation's own. */
  readonly meshes: readonly Mesh[];
  /** Named numbers, where the answer has them. */
  readonly figures: Readonly<Record<string, number>>;
}

export interface ArchiveAt {
  readonly id: ArchiveId;
  readonly generation: number;
}

export interface FindAnswer {
  readonly found: readonly { readonly id: ArchiveId; readonly entries: readonly Entry[] }[];
  /** `column` counts characters of the query from 1. */
  readonly errors: readonly { readonly id: ArchiveId; readonly column: number; readonly message: string }[];
}

export interface GroupsAsk extends ArchiveAt {
  /** null: all. */
  readonly entries: readonly Entry[] | null;
  readonly groups: number;
  readonly by: "medoids" | "hierarchy";
}

export interface Group {
  readonly representative: Entry;
  readonly members: readonly Entry[];
  readonly mean_m: number;
  readonly greatest_m: number;
  /** Of satisfied draws; null where draws are not in proportion. */
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

/** Something that can be plotted. */
export interface SeriesTitle {
  readonly name: string;
  readonly title: string;
  readonly kind: string;
  /** Plots of one group stand together. */
  readonly group: string;
}

/** A plot's data: what the head says, and named columns. */
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

/** What is changed of a note; what others change meanwhile stays. */
export interface NotePatch {
  readonly star?: boolean;
  readonly hidden?: boolean;
  readonly note?: string;
  readonly tags_on?: readonly string[];
  readonly tags_off?: readonly string[];
}

/** As kept: `changed` grows with every change. */
export interface KeptNote extends Note {
  readonly changed: number;
}

/** By run, then by the animation's name. */
export interface Notes {
  readonly notes: Readonly<Record<string, Readonly<Record<AnimationName, KeptNote>>>>;
}

/** What was changed, whole; `words`: why it lasts no longer than the gallery, "" where it does. */
export interface ChangedNotes {
  readonly notes: Readonly<Record<AnimationName, KeptNote>>;
  readonly words: string;
}

/** A name as it is today: "0.250" is how older pages wrote "c0.250". */
export function nameToday(name: string): AnimationName {
  return /^\d/.test(name) ? `c${name}` : name;
}

/** Of an archive's table row: what it is called. */
export function nameOf(table: Table, entry: Entry): AnimationName {
  const draw = String(table.draw[entry] ?? 0);
  return table.isFind[entry] ? `find.${draw}` : `c${String(table.chain[entry] ?? 0)}.${draw}`;
}
