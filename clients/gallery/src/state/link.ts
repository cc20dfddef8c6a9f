// Converts the page's state to the part of its address after '#', and back. Unknown and invalid parts are
// skipped, so that old or hand-written links still open.
import {
  firstPage,
  groupsMax,
  groupsMin,
  noNotesFilter,
  type Chip,
  type Grouping,
  type NotesFilter,
  type Page,
  type PathStep,
  type View,
} from "./page";
import { nameToday } from "../data/types";
import type { CameraState } from "../view/camera";
import { shortNumber } from "./query-text";
import { sortFromText, sortToText } from "./sorting";

/** Longer links aren't ours. Browsers' own limits are higher. */
export const linkSignsMax = 500_000;

const signs = { in: "in:", not: "not:", offIn: "off-in:", offNot: "off-not:" };

/** The link without '#'. Default values are omitted. */
export function linkOf(page: Page): string {
  const parts = new URLSearchParams();
  const put = (name: string, value: string, initial = ""): void => {
    if (value !== initial) parts.append(name, value);
  };
  put("run", page.run);
  put("archive", page.archive);
  put("view", page.view, firstPage.view);
  for (const chip of page.chips) {
    const sign = chip.isOn ? (chip.isNot ? signs.not : signs.in) : chip.isNot ? signs.offNot : signs.offIn;
    parts.append("q", sign + chip.text);
  }
  put("star", page.notesFilter.star ? "1" : "");
  put("tag", page.notesFilter.tag);
  put("hidden", page.notesFilter.hidden, noNotesFilter.hidden);
  put("groups", groupingText(page.grouping), groupingText(firstPage.grouping));
  for (const step of page.path)
    parts.append("in", `${groupingText(step)}:${step.representative}:${step.query}`);
  put("sort", sortToText(page.sort));
  put("selected", page.selected.join(","));
  put("play", page.playing.join(","));
  put("sync", page.sync, firstPage.sync);
  if (page.camera !== null) {
    const { azimuth, elevation, zoom, target } = page.camera;
    put("camera", [azimuth, elevation, zoom, ...(target ?? [])].map(fourDigits).join(","));
  }
  if (page.timeS !== null) put("t", fourDigits(page.timeS));
  put("plot", page.plot);
  return parts.toString();
}

export function pageOf(link: string): Page {
  if (link.length > linkSignsMax) return firstPage;
  const parts = new URLSearchParams(link.replace(/^#/, ""));
  const text = (name: string): string => parts.get(name) ?? "";
  const hidden = text("hidden");
  const notesFilter: NotesFilter = {
    star: text("star") === "1",
    tag: text("tag"),
    hidden: hidden === "with" || hidden === "only" ? hidden : "without",
  };
  const view = text("view");
  const sync = text("sync");
  return {
    run: text("run"),
    archive: text("archive"),
    view: isView(view) ? view : firstPage.view,
    chips: parts.getAll("q").flatMap(chipOf),
    notesFilter,
    grouping: groupingOf(text("groups")) ?? firstPage.grouping,
    path: parts.getAll("in").flatMap(stepOf),
    sort: sortFromText(text("sort")),
    selected: names(text("selected")),
    playing: names(text("play")),
    sync: sync === "contact" || sync === "end" ? sync : "start",
    camera: cameraOf(text("camera")),
    timeS: numberOf(text("t")),
    plot: text("plot"),
  };
}

/** The part of the state whose changes add to the browser's history: all but time, camera and selection. */
export function placeOf(page: Page): string {
  return linkOf({ ...page, camera: null, timeS: null, selected: [] });
}

function isView(text: string): text is View {
  return text === "groups" || text === "list" || text === "plots";
}

function names(text: string): string[] {
  return text === "" ? [] : [...new Set(text.split(",").filter((name) => /^[a-z0-9.]{1,40}$/.test(name)).map(nameToday))];
}

function numberOf(text: string): number | null {
  const value = text === "" ? NaN : Number(text);
  return Number.isFinite(value) ? value : null;
}

function fourDigits(value: number): string {
  return shortNumber(Math.round(value * 1e4) / 1e4);
}

function groupingText(grouping: Grouping): string {
  return `${grouping.by}-${grouping.groups}`;
}

function groupingOf(text: string): Grouping | null {
  const found = /^(medoids|hierarchy)-(\d{1,4})$/.exec(text);
  if (found === null) return null;
  const groups = Math.min(groupsMax, Math.max(groupsMin, Number(found[2])));
  return { groups, by: found[1] === "hierarchy" ? "hierarchy" : "medoids" };
}

function chipOf(text: string, index: number): Chip[] {
  const found = /^(off-)?(in|not):([^]*)$/.exec(text);
  if (found === null || found[3] === undefined || found[3].trim() === "") return [];
  return [{ id: index + 1, text: found[3], isNot: found[2] === "not", isOn: found[1] === undefined }];
}

function stepOf(text: string): PathStep[] {
  const found = /^([a-z]+-\d+):([a-z0-9.]+):([^]*)$/.exec(text);
  const grouping = groupingOf(found?.[1] ?? "");
  if (found === null || grouping === null) return [];
  return [{ ...grouping, representative: nameToday(found[2] ?? ""), query: found[3] ?? "" }];
}

function cameraOf(text: string): CameraState | null {
  const values = text.split(",").map(numberOf);
  const [azimuth, elevation, zoom, x, y, z] = values;
  if ((values.length !== 3 && values.length !== 6) || values.includes(null) || !zoom || zoom <= 0)
    return null;
  const target = values.length === 3 ? null : ([x ?? 0, y ?? 0, z ?? 0] as const);
  return { azimuth: azimuth ?? 0, elevation: elevation ?? 0, zoom, target };
}
