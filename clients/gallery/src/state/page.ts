// What a link to the page holds: the part of the state that a person would want to find again. It
// names things by what outlives a server: the run, and animations' names.
import type { Box } from "./conditions";
import { asKept, type SortKey } from "./sorting";

export type View = "groups" | "list" | "plots";
export type GroupsBy = "medoids" | "hierarchy";
export type SyncMode = "start" | "contact" | "end";

export interface Chip {
  /** Tells chips apart while the page is open; links don't hold it. */
  readonly id: number;
  readonly text: string;
  readonly isNot: boolean;
  readonly isOn: boolean;
}

export interface NotesFilter {
  readonly star: boolean;
  /** "": any or none. */
  readonly tag: string;
  readonly hidden: "without" | "with" | "only";
}

export interface Grouping {
  readonly groups: number;
  readonly by: GroupsBy;
}

/** A group that was opened: of those that `query` let through, the one that has this animation. */
export interface PathStep extends Grouping {
  readonly representative: string;
  readonly query: string;
}

export interface Camera {
  readonly azimuth: number;
  readonly elevation: number;
  readonly zoom: number;
  /** null: the middle of the scene's view. */
  readonly target: readonly [number, number, number] | null;
}

export interface Page {
  readonly run: string;
  /** The archive's name, where several are of the run; "": any of them. */
  readonly archive: string;
  readonly view: View;
  readonly chips: readonly Chip[];
  readonly notesFilter: NotesFilter;
  readonly grouping: Grouping;
  readonly path: readonly PathStep[];
  readonly sort: SortKey;
  readonly selected: readonly string[];
  readonly playing: readonly string[];
  readonly sync: SyncMode;
  readonly camera: Camera | null;
  readonly timeS: number | null;
  readonly plot: string;
}

/** How many groups can be asked for. */
export const groupsMin = 2;
export const groupsMax = 60;

export const noNotesFilter: NotesFilter = { star: false, tag: "", hidden: "without" };

export const firstPage: Page = {
  run: "",
  archive: "",
  view: "groups",
  chips: [],
  notesFilter: noNotesFilter,
  grouping: { groups: 12, by: "medoids" },
  path: [],
  sort: asKept,
  selected: [],
  playing: [],
  sync: "start",
  camera: null,
  timeS: null,
  plot: "",
};

/** A box as the player draws it, in metres of the scene's frame. */
export interface DrawnBox {
  readonly low: readonly [number, number, number];
  readonly high: readonly [number, number, number];
}

/** To whole tenths of a millimetre: a hand is no finer, and the query's text stays short. */
export function boxOfDrawn(drawn: DrawnBox): Box {
  const range = (axis: 0 | 1 | 2): { low: number; high: number } => ({
    low: Math.round(drawn.low[axis] * 1e4) / 1e4,
    high: Math.round(drawn.high[axis] * 1e4) / 1e4,
  });
  return { x: range(0), y: range(1), z: range(2) };
}
