// Joins the page's parts, keys and state.
import "../styles/base.css";
import "../styles/layout.css";
import "../styles/filters.css";
import "../styles/wall.css";
import "../styles/player.css";
import "../styles/plots.css";
import type { GallerySource } from "../data/source";
import { Address } from "../state/address";
import type { AppState } from "../state/app-state";
import { Asking } from "../state/asking";
import { actedOn } from "../state/derived";
import { pageOf } from "../state/link";
import { Loading } from "../state/loading";
import { NoteKeeping } from "../state/note-keeping";
import { ofShownRun } from "../state/own-run";
import { initialState, PageActions } from "../state/page-actions";
import { Store } from "../state/store";
import { SharedRenderer } from "../view/renderer";
import { installTestHook } from "../view/test-hook";
import { el, setAttribute } from "./dom";
import { makeFiltersPanel } from "./filters-panel";
import { makeHeader } from "./header";
import { listenToKeys, makeKeysDialog, type KeyActions } from "./keys";
import type { Part, Ui } from "./part";
import { makePlayerPanel, type PlayerPanel } from "./player-panel";
import { makePlotsFrame } from "./plots-frame";
import { makeSelectionBar } from "./selection-bar";
import { makeStatusLine } from "./status-line";
import { Theme } from "./theme";
import { makeToolbar } from "./toolbar";
import { makeWall, type Wall } from "./wall";

/** Below this width the player covers the wall. */
const wideQuery = "(min-width: 1100px)";

export function startApp(galleries: GallerySource): void {
  const root = document.getElementById("app")!;
  const store = new Store<AppState>(initialState(pageOf(location.hash)));
  const source = ofShownRun(galleries, store);
  const loading = new Loading(store, galleries);
  const lookAgain = (): void => void loading.lookAgain();
  const notes = new NoteKeeping(store, source);
  const page = new PageActions(store, notes, lookAgain);
  page.applyLink(location.hash);
  const ui: Ui = { store, source, loading, page, notes, theme: new Theme() };
  const renderer = new SharedRenderer();
  loading.start();
  // Checking the renderer creates the WebGL context, so do it while the first archive loads.
  const waited = store.subscribe(({ gallery }) => {
    if (gallery === null) return;
    waited();
    setTimeout(() => store.set({ hasNoPictures: !renderer.available }));
  });

  const keysDialog = makeKeysDialog();
  const wall = makeWall(ui, renderer);
  const player = makePlayerPanel(
    ui,
    renderer,
    () => wall.stage,
    (isPlaying) => wall.pause(isPlaying),
  );
  const filters = makeFiltersPanel(ui);
  const toggleFilters = (): void => {
    const isOpen = root.classList.toggle("filters-open");
    setAttribute(document.getElementById("toggle-filters") ?? root, "aria-expanded", String(isOpen));
  };
  const header = makeHeader(ui, () => keysDialog.showModal(), toggleFilters);
  const toolbar = makeToolbar(ui, () => wall.focusedName);
  const plots = makePlotsFrame(ui);
  const selection = makeSelectionBar(ui);
  const status = makeStatusLine();
  const main = el(
    "main",
    { class: "main", id: "main", "aria-label": "Animations" },
    toolbar.element,
    wall.element,
    plots.element,
    selection.element,
  );
  root.append(
    header.element,
    el("div", { class: "body" }, filters.element, main, player.element),
    status.element,
    keysDialog,
  );

  const parts: readonly Part[] = [header, filters, toolbar, wall, plots, selection, player, status];
  const show = (state: AppState, before: AppState): void => {
    root.classList.toggle("player-open", state.page.playing.length > 0);
    for (const part of parts) part.update(state, before);
  };
  show(store.state, store.state);
  store.subscribe(show);
  new Asking(store, source, lookAgain).start();
  notes.start(window);
  new Address(store, (link) => page.applyLink(link)).start();
  listenToKeys(keyActions(ui, { wall, player, filters, root, showKeys: () => keysDialog.showModal() }));
  installTestHook(renderer, () => (store.state.page.playing.length > 0 ? player.player : null));
}

interface Places {
  readonly wall: Wall;
  readonly player: PlayerPanel;
  readonly filters: { focusQuery(): void };
  readonly root: HTMLElement;
  readonly showKeys: () => void;
}

function keyActions(ui: Ui, { wall, player, filters, root, showKeys }: Places): KeyActions {
  const { store, page, notes, loading } = ui;
  const isOpen = (): boolean => store.state.page.playing.length > 0;
  // If the player has the focus, keys act on the playing animations. Otherwise keys act on the selection or
  // the card.
  const names = (): readonly string[] =>
    isOpen() && player.element.contains(document.activeElement)
      ? store.state.page.playing
      : actedOn(store.state, wall.element.contains(document.activeElement) ? wall.focusedName : null);
  const withPlayer = (act: () => void) => (): void => {
    if (isOpen()) act();
  };
  return {
    help: showKeys,
    query: () => {
      if (!matchMedia(wideQuery).matches) root.classList.add("filters-open");
      filters.focusQuery();
    },
    wall: () => wall.focus(),
    player: withPlayer(() => player.focus()),
    view: (view) => page.showView(view),
    up: () => {
      const depth = store.state.page.path.length;
      if (depth > 0) page.closeTo(depth - 1);
    },
    activate: () => wall.activate(),
    choose: (isExtend) => {
      const name = wall.focusedName;
      if (name !== null) page.select(name, isExtend ? "extend" : "toggle");
    },
    all: () => page.selectAll(),
    compare: () => {
      if (store.state.selection.names.length > 0) page.play(store.state.selection.names);
    },
    star: () => notes.toggle(names(), "star"),
    hide: () => notes.toggle(names(), "hidden"),
    like: (isUnlike) => page.sortByLikeness(names(), isUnlike),
    takeNew: () => loading.takeOffered(),
    undo: () => notes.undo(),
    redo: () => notes.redo(),
    toggle: withPlayer(() => player.player.toggle()),
    step: (frames) => withPlayer(() => player.player.step(frames))(),
    event: (direction) => withPlayer(() => player.player.toEvent(direction))(),
    trails: withPlayer(() => player.toggleTrails()),
    still: () => ui.theme.moveCards(ui.theme.areCardsStill),
    turn: (across, up) => player.player.orbit(across, up),
    zoom: (factor) => player.player.zoom(factor),
    escape: () => {
      if (root.classList.contains("filters-open")) root.classList.remove("filters-open");
      else if (isOpen()) {
        page.closePlayer();
        wall.focus();
      } else page.selectNone();
    },
  };
}
