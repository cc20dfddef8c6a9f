// Keyboard shortcuts and their list. A field or button receives the keys that it uses itself.
import { el, iconButton } from "./dom";

export interface KeyActions {
  readonly help: () => void;
  readonly query: () => void;
  readonly wall: () => void;
  readonly player: () => void;
  readonly view: (view: "groups" | "list" | "plots") => void;
  readonly up: () => void;
  readonly activate: () => void;
  readonly choose: (isExtend: boolean) => void;
  readonly all: () => void;
  readonly compare: () => void;
  readonly star: () => void;
  readonly hide: () => void;
  readonly like: (isUnlike: boolean) => void;
  readonly takeNew: () => void;
  readonly undo: () => void;
  readonly redo: () => void;
  readonly toggle: () => void;
  readonly step: (frames: number) => void;
  readonly event: (direction: 1 | -1) => void;
  readonly trails: () => void;
  readonly still: () => void;
  readonly turn: (across: number, up: number) => void;
  readonly zoom: (factor: number) => void;
  readonly escape: () => void;
}

const shownKeys: readonly (readonly [string, string])[] = [
  ["?", "show this list"],
  ["/", "go to the query"],
  ["w", "go to the wall"],
  ["p", "go to the player"],
  ["1, 2, 3", "show groups, list or plots"],
  ["arrows, Home, End, Page", "go to another card"],
  ["Enter", "open the group or play the animation"],
  ["Backspace", "leave the group"],
  ["Space, Shift+Space", "on a card: select it, or all cards up to it; elsewhere: play or pause"],
  ["Ctrl+A", "select all animations shown"],
  ["c", "compare the selected animations"],
  ["s", "star or unstar"],
  ["h", "hide or unhide"],
  ["m, u", "sort by likeness: most similar first (m), or least similar first (u)"],
  ["n", "show new animations"],
  ["Ctrl+Z, Ctrl+Shift+Z", "undo, redo"],
  ["k", "play or pause"],
  [", and .", "one frame back or forward (with Shift: ten)"],
  ["[ and ]", "previous or next event"],
  ["t", "show or hide trails"],
  ["e", "animate cards, or show how animations end"],
  ["arrows on the picture", "turn the camera; + and − zoom"],
  ["Escape", "close the player, then clear the selection"],
];

export function listenToKeys(actions: KeyActions): void {
  document.addEventListener("keydown", (event) => {
    if (event.defaultPrevented) return;
    const target = event.target instanceof HTMLElement ? event.target : document.body;
    if (target.closest("dialog[open]") !== null) return;
    const isDone = isTyping(target)
      ? false
      : withControl(event, actions, target) || plain(event, actions, target);
    if (isDone) event.preventDefault();
  });
}

/** Shortcuts are off while a person types in a field; there undo is the field's own. */
function isTyping(target: HTMLElement): boolean {
  if (target instanceof HTMLTextAreaElement || target instanceof HTMLSelectElement) return true;
  return target instanceof HTMLInputElement && target.type !== "checkbox";
}

function withControl(event: KeyboardEvent, actions: KeyActions, target: HTMLElement): boolean {
  if (!(event.ctrlKey || event.metaKey) || event.altKey) return false;
  const key = event.key.toLowerCase();
  if (key === "z" && event.shiftKey) actions.redo();
  else if (key === "z") actions.undo();
  else if (key === "y") actions.redo();
  else if (key === "a" && target.closest("[role=grid]") !== null) actions.all();
  else return false;
  return true;
}

function plain(event: KeyboardEvent, actions: KeyActions, target: HTMLElement): boolean {
  if (event.ctrlKey || event.metaKey || event.altKey) return false;
  const { key } = event;
  const onCard = target.getAttribute("role") === "gridcell";
  const onPicture = target.id === "player-canvas";
  const isControl = target.closest("button, summary, a, input") !== null;
  if (onPicture && turned(key, actions)) return true;
  if (key === " " && !isControl) {
    if (onCard) actions.choose(event.shiftKey);
    else actions.toggle();
    return true;
  }
  if (key === "Enter") {
    if (onCard) actions.activate();
    return onCard;
  }
  const act = letters(actions, event.shiftKey ? 10 : 1)[key.length === 1 ? key.toLowerCase() : key];
  act?.();
  return act !== undefined;
}

function turned(key: string, actions: KeyActions): boolean {
  const step = 0.1;
  if (key === "ArrowLeft") actions.turn(-step, 0);
  else if (key === "ArrowRight") actions.turn(step, 0);
  else if (key === "ArrowUp") actions.turn(0, step);
  else if (key === "ArrowDown") actions.turn(0, -step);
  else if (key === "+" || key === "=") actions.zoom(1.25);
  else if (key === "-") actions.zoom(0.8);
  else return false;
  return true;
}

function letters(actions: KeyActions, frames: number): Readonly<Record<string, () => void>> {
  return {
    "?": actions.help,
    "/": actions.query,
    w: actions.wall,
    p: actions.player,
    "1": () => actions.view("groups"),
    "2": () => actions.view("list"),
    "3": () => actions.view("plots"),
    Backspace: actions.up,
    c: actions.compare,
    s: actions.star,
    h: actions.hide,
    m: () => actions.like(false),
    u: () => actions.like(true),
    n: actions.takeNew,
    k: actions.toggle,
    ",": () => actions.step(-1),
    ".": () => actions.step(1),
    // On most keyboards Shift turns "," and "." into these characters.
    "<": () => actions.step(-frames),
    ">": () => actions.step(frames),
    ";": () => actions.step(-frames),
    ":": () => actions.step(frames),
    "[": () => actions.event(-1),
    "]": () => actions.event(1),
    t: actions.trails,
    e: actions.still,
    Escape: actions.escape,
  };
}

export function makeKeysDialog(): HTMLDialogElement {
  const rows = shownKeys.map(([key, words]) =>
    el("tr", {}, el("th", { scope: "row" }, el("kbd", {}, key)), el("td", {}, words)),
  );
  const dialog = el(
    "dialog",
    { class: "keys", id: "keys", "aria-labelledby": "keys-title" },
    el(
      "div",
      { class: "player-head" },
      el("h2", { id: "keys-title" }, "Keys"),
      iconButton("close", "Close", () => dialog.close()),
    ),
    el("table", {}, el("tbody", {}, ...rows)),
  );
  // Browsers may use the first Escape themselves if no click opened the dialog, and leave it open.
  dialog.addEventListener("keydown", (event) => {
    if (event.key === "Escape") dialog.close();
  });
  return dialog;
}
