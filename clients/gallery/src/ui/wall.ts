// The wall: a grid of groups or of animations. Both grids share one set of animated thumbnails.
import type { Animation } from "../data/types";
import type { AppState, Loaded } from "../state/app-state";
import { archiveShown, areGroupsThere, orderedNames } from "../state/derived";
import type { PathStep } from "../state/page";
import type { SharedRenderer } from "../view/renderer";
import { ArchiveStage } from "../view/stage";
import { Thumbnails } from "../view/thumbnails";
import { animationCard, groupCard, updateAnimationCard, type CardAct } from "./card";
import { el, setHidden, setText } from "./dom";
import type { Part, Ui } from "./part";
import { VirtualGrid } from "./virtual-grid";

export interface Wall extends Part {
  /** The animation, or the group's representative, whose card has or last had the focus. */
  readonly focusedName: string | null;
  focus(): void;
  /** Performs Enter on the focused card. */
  activate(): void;
  /** Pauses the cards while the player plays, to save computing time. */
  pause(isPaused: boolean): void;
  /** Shared with the player; null until an archive is loaded. */
  readonly stage: ArchiveStage | null;
}

const cardRowHeight = 286;
const columnWidthMin = 216;

export function makeWall(ui: Ui, renderer: SharedRenderer): Wall {
  let stage: ArchiveStage | null = null;
  let thumbnails: Thumbnails | null = null;
  let shown: Loaded | null = null;
  let isStopped = false;
  let groupsOf = new Map<string, number>();
  /** Set if the wall had the focus when the view or the open group changed. */
  let owed: { readonly left: PathStep | null } | null = null;

  const show = (canvas: HTMLCanvasElement): void => thumbnails?.show(canvas, canvas.dataset["name"] ?? "");
  const drop = (cell: HTMLElement): void => {
    const canvas = cell.querySelector("canvas");
    if (canvas !== null) thumbnails?.hide(canvas);
  };
  const common = { rowHeight: cardRowHeight, columnWidthMin, drop };
  const list = new VirtualGrid({
    ...common,
    id: "list",
    label: "Animations",
    render: (key) => {
      const { cell, canvas } = animationCard(key);
      updateAnimationCard(cell, ui.store.state, key);
      show(canvas);
      return cell;
    },
  });
  const groups = new VirtualGrid({
    ...common,
    id: "groups",
    label: "Groups of similar animations",
    render: (key) => {
      const { loaded, groups: answer } = ui.store.state;
      const group = answer?.list[groupsOf.get(key) ?? -1];
      if (loaded === null || group === undefined) return el("div", { class: "card" });
      const { cell, canvas } = groupCard(loaded, group);
      show(canvas);
      return cell;
    },
  });
  const empty = el("p", { class: "empty", id: "empty" });
  const element = el("div", { class: "wall" }, empty, groups.element, list.element);

  const current = (): VirtualGrid => (ui.store.state.page.view === "groups" ? groups : list);
  const nameOfKey = (key: string | null): string | null => {
    if (key === null || current() === list) return key;
    const { loaded, groups: answer } = ui.store.state;
    const group = answer?.list[groupsOf.get(key) ?? -1];
    return group === undefined ? null : (loaded?.names[group.representative] ?? null);
  };
  const activate = (): void => {
    const key = current().activeKey;
    if (key !== null) act(key, current() === groups ? "open" : "play");
  };
  const act = (key: string, what: CardAct): void => {
    const name = nameOfKey(key);
    if (name === null) return;
    if (what === "open") {
      const group = ui.store.state.groups?.list[groupsOf.get(key) ?? -1];
      if (group !== undefined) ui.page.openGroup(group);
    } else if (what === "play") ui.page.play([name]);
    else if (what === "star") ui.notes.toggle([name], "star");
    else if (what === "hide") ui.notes.toggle([name], "hidden");
    else if (what === "like") ui.page.sortByLikeness([name], false);
    else ui.page.select(name, "toggle");
  };
  element.addEventListener("click", (event) => {
    const target = event.target as Element;
    const key = target.closest<HTMLElement>("[role=gridcell]")?.dataset["key"];
    if (key === undefined) return;
    const asked = target.closest<HTMLElement>("[data-act]")?.dataset["act"] as CardAct | undefined;
    if (asked !== undefined) act(key, asked);
    else if (current() === groups) act(key, "open");
    else ui.page.select(key, event.shiftKey ? "extend" : "toggle");
  });
  element.addEventListener("dblclick", (event) => {
    const cell = (event.target as Element).closest<HTMLElement>("[role=gridcell]");
    const onButton = (event.target as Element).closest("[data-act]") !== null;
    if (cell !== null && !onButton && current() === list) act(cell.dataset["key"] ?? "", "play");
  });

  const showStage = (loaded: Loaded): void => {
    if (shown?.scene === loaded.scene && shown.looks === loaded.looks) {
      shown = loaded;
      return;
    }
    shown = loaded;
    const next = new ArchiveStage(loaded.scene, loaded.looks);
    const load = (names: readonly string[], signal: AbortSignal): Promise<Animation[]> => {
      const { loaded: now } = ui.store.state;
      return ui.source.animations(now?.id ?? loaded.id, names, loaded.bodies, { signal });
    };
    thumbnails?.dispose();
    thumbnails = new Thumbnails(renderer, {
      load,
      stage: next,
      theme: ui.theme.shade,
      still: ui.theme.areCardsStill,
    });
    thumbnails.pause(isStopped);
    stage?.dispose();
    stage = next;
  };
  ui.theme.onChange(() => {
    thumbnails?.setTheme(ui.theme.shade);
    thumbnails?.setStill(ui.theme.areCardsStill);
  });

  const oweFocus = (state: AppState, before: AppState): void => {
    const { page } = state;
    if (page.path === before.page.path && page.view === before.page.view) return;
    const hadFocus = element.contains(document.activeElement) || (owed !== null && isFocusNowhere());
    const isOut = page.path.length < before.page.path.length;
    owed = hadFocus ? { left: (isOut ? before.page.path[page.path.length] : null) ?? null } : null;
  };
  /** Focuses the first new card, or the card of the group that was left. */
  const payFocus = (state: AppState): void => {
    if (owed === null || state.page.view === "plots" || !isAnswered(state)) return;
    const { left } = owed;
    owed = null;
    // If a person focused something else meanwhile, the focus stays there.
    if (!isFocusNowhere() && !element.contains(document.activeElement)) return;
    const entry = left === null ? undefined : state.loaded?.entryOf.get(left.representative);
    const group = entry === undefined ? -1 : groupWith(state, entry);
    if (state.page.view === "groups" && group >= 0) groups.focusKey(groupKeys(state)[group] ?? "");
    else current().focus();
  };

  const update = (state: AppState, before: AppState): void => {
    const { loaded, page } = state;
    oweFocus(state, before);
    const isOtherRun = loaded?.run !== before.loaded?.run || loaded?.id !== before.loaded?.id;
    if (loaded !== null) showStage(loaded);
    const isGroups = page.view === "groups";
    setHidden(groups.element, !isGroups);
    setHidden(list.element, page.view !== "list");
    setHidden(element, page.view === "plots");
    const viewChanged = state === before || page.view !== before.page.view || isOtherRun;
    if (isGroups && (viewChanged || state.groups !== before.groups)) {
      const keys = groupKeys(state);
      groupsOf = new Map(keys.map((key, i) => [key, i]));
      groups.setKeys(keys, page.path !== before.page.path || isOtherRun);
    }
    if (page.view === "list") {
      const names = orderedNames(state);
      const isOther =
        page.path !== before.page.path ||
        page.sort !== before.page.sort ||
        isOtherRun ||
        state.distances?.to !== before.distances?.to;
      if (viewChanged || names !== orderedNames(before)) list.setKeys(names, isOther);
      if (cardsChanged(state, before)) list.forEachCell((cell, key) => updateAnimationCard(cell, state, key));
    }
    const words = emptyWords(state, ui.source.isLive);
    setText(empty, words);
    setHidden(empty, words === "");
    payFocus(state);
  };
  return {
    element,
    update,
    activate,
    pause: (isPaused) => {
      isStopped = isPaused;
      thumbnails?.pause(isPaused);
    },
    focus: () => current().focus(),
    get focusedName() {
      return nameOfKey(current().activeKey);
    },
    get stage() {
      return stage;
    },
  };
}

function cardsChanged(state: AppState, before: AppState): boolean {
  return (
    state === before ||
    state.selection !== before.selection ||
    state.notes !== before.notes ||
    state.loaded !== before.loaded ||
    state.page.playing !== before.page.playing ||
    state.page.sort !== before.page.sort ||
    state.distances !== before.distances
  );
}

/** Browsers focus the body when a focused element is hidden, some only at the next frame. */
function isFocusNowhere(): boolean {
  return (document.activeElement ?? document.body) === document.body;
}

/** Whether the grid shows what the page now requests. */
function isAnswered(state: AppState): boolean {
  if (state.loaded === null || state.opened.includes(null)) return false;
  return state.page.view !== "groups" || areGroupsThere(state);
}

/** Index of the group that the entry represents, else of the group that contains it; -1 if none. */
function groupWith(state: AppState, entry: number): number {
  const list = state.groups?.list ?? [];
  const own = list.findIndex(({ representative }) => representative === entry);
  return own >= 0 ? own : list.findIndex(({ members }) => members.includes(entry));
}

/** The key of a group changes whenever its card's text changes. */
function groupKeys(state: AppState): string[] {
  const { loaded, groups } = state;
  return (groups?.list ?? []).map((group) => {
    const name = loaded?.names[group.representative] ?? "";
    return [name, group.members.length, group.mean_m, group.share?.value ?? ""].join(" ");
  });
}

/** If the gallery doesn't follow the run, the page cannot know whether the run has ended. */
function noneKeptWords(state: AppState, isServed: boolean): string {
  if (archiveShown(state)?.is_live)
    return "The archive has no kept animations yet. New animations will be offered here.";
  const ifItGoesOn = isServed ? " If the run continues, new animations will be offered here." : "";
  return `The archive has no kept animations.${ifItGoesOn}`;
}

function emptyWords(state: AppState, isServed: boolean): string {
  if (state.loaded === null) return state.loadFailure || "Reading the archive …";
  if (state.page.view === "plots") return "";
  if (state.visible.length === 0) return noneKeptWords(state, isServed);
  const nothing =
    state.page.view === "list" ? orderedNames(state).length === 0 : state.groups?.of.length === 0;
  if (!nothing || state.opened.includes(null)) return "";
  return "No animations match. Switch off or delete a query, or press Ctrl+Z to undo the last change.";
}
