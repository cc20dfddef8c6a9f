// The part of the state that links contain. Links contain names that outlive a server: the run's and the
// animations' names.
import type { SyncMode } from "../motion/sync";
import type { CameraState } from "../view/camera";
import type { Box } from "./conditions";
import { asKept, type SortKey } from "./sorting";

export type View = "groups" | "list" | "plots";
export type GroupsBy = "medoids" | "hierarchy";

export interface Chip {
  /** Distinguishes chips while the page is open; links don't contain it. */
  readonly id: number;
  readonly text: string;
  readonly isNot: boolean;
  readonly isOn: boolean;
}

export interface NotesFilter {
  readonly star: boolean;
  /** "": any tag or none. */
  readonly tag: string;
  readonly hidden: "without" | "with" | "only";
}

export interface Grouping {
  readonly groups: number;
  readonly by: GroupsBy;
}

/** An open group: the group of animations matching `query` that contains `representative`. */
export interface PathStep extends Grouping {
  readonly representative: string;
  readonly query: string;
}

export interface Page {
  readonly run: string;
  /** The archive's name, if several archives contain the run; "": any archive. */
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
  readonly camera: CameraState | null;
  readonly timeS: number | null;
  readonly plot: string;
}

/** Limits of the number of groups. */
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

/** A box drawn in the player, in metres of the scene's frame. */
export interface DrawnBox {
  readonly low: readonly [number, number, number];
  readonly high: readonly [number, number, number];
}

/** Rounds to 0.1 mm: people don't draw more exactly, and the query's text stays short. */
export function boxOfDrawn(drawn: DrawnBox): Box {
  const range = (axis: 0 | 1 | 2): { low: number; high: number } => ({
    low: Math.round(drawn.low[axis] * 1e4) / 1e4,
    high: Math.round(drawn.high[axis] * 1e4) / 1e4,
  });
  return { x: range(0), y: range(1), z: range(2) };
}
