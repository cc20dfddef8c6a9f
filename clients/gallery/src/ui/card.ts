// Cards of the wall: one for an animation, one for a group of similar animations.
import type { AppState, Loaded, ShownGroup } from "../state/app-state";
import { noteOf } from "../data/note-patch";
import {
  ordinaryWords,
  plausibilityHelp,
  plausibilityWords,
  proportionHelp,
  scoreHelp,
  shareHelp,
} from "../state/plausibility";
import { isSelected } from "../state/selection";
import { el, iconOf, setAttribute, setHidden, setText } from "./dom";
import { cardNumber, count, millimetres, number, share } from "./words";

/** Action of a card's button, from its attribute data-act. */
export type CardAct = "play" | "star" | "hide" | "select" | "open" | "like";

const badgeWords = "not in proportion";

interface CardParts {
  readonly cell: HTMLElement;
  readonly canvas: HTMLCanvasElement;
}

let cards = 0;

/** The card's text is the cell's accessible name. */
function frame(kind: string): CardParts & { readonly box: HTMLElement; readonly wordsId: string } {
  cards += 1;
  const wordsId = `card-words-${cards}`;
  const canvas = el("canvas", { class: "thumbnail", "aria-hidden": "true" });
  const box = el("div", { class: "card-box" });
  box.append(el("div", { class: "card-picture" }, canvas));
  return {
    cell: el("div", { class: `card card-${kind}`, "aria-labelledby": wordsId }, box),
    canvas,
    box,
    wordsId,
  };
}

/** A card's button for the mouse. Keys act on the card itself, so the button is no tab stop. */
function act(name: CardAct, label: string, child: Node | string): HTMLButtonElement {
  return el(
    "button",
    {
      type: "button",
      tabindex: -1,
      "data-act": name,
      "aria-label": label,
      title: label,
      class: "card-button",
    },
    child,
  );
}

/** Adds blanks between the parts: screen readers read the card's text as one line. */
function spaced(...parts: HTMLElement[]): (HTMLElement | string)[] {
  return parts.flatMap((part) => [part, " "]);
}

function line(...parts: HTMLElement[]): HTMLElement {
  return el("div", { class: "card-line" }, ...spaced(...parts));
}

/** Creates an empty card; updateAnimationCard fills it. */
export function animationCard(name: string): CardParts {
  const { cell, canvas, box, wordsId } = frame("animation");
  canvas.dataset["name"] = name;
  box.append(
    el(
      "div",
      { class: "card-tools" },
      act("select", `Select ${name}`, iconOf("check")),
      act("star", `Star ${name}`, iconOf("star")),
      act("hide", `Hide ${name}`, iconOf("eyeOff")),
      act("play", `Play ${name}`, iconOf("play")),
    ),
    el(
      "div",
      { class: "card-words", id: wordsId },
      ...spaced(
        line(
          el("strong", { class: "card-name" }, name),
          el("span", { class: "card-score", title: scoreHelp }),
        ),
        el("div", { class: "card-plausibility", title: plausibilityHelp }),
        line(el("span", { class: "card-sort" }), el("span", { class: "card-tags" })),
        line(
          el("span", { class: "badge", title: proportionHelp }, badgeWords),
          el("span", { class: "card-marks" }),
        ),
      ),
    ),
  );
  return { cell, canvas };
}

export function updateAnimationCard(cell: HTMLElement, state: AppState, name: string): void {
  const { loaded } = state;
  const entry = loaded?.entryOf.get(name);
  if (loaded === null || entry === undefined) return;
  const note = noteOf(state.notes, name);
  const chosen = isSelected(state.selection, name);
  const score = numberOf(loaded, entry, "log_constraint");
  const plausibility = plausibilityOf(loaded, entry);
  const inProportion = loaded.table.inProportion[entry] === 1;
  const part = (selector: string): HTMLElement | null => cell.querySelector<HTMLElement>(selector);
  const put = (selector: string, text: string): void => {
    const element = part(selector);
    if (element !== null) setText(element, text);
  };
  put(".card-score", Number.isNaN(score) ? "" : `score ${cardNumber(score)}`);
  put(".card-plausibility", plausibility);
  put(".card-sort", sortWords(state, loaded, entry));
  put(".card-tags", note.tags.map((tag) => `#${tag}`).join(" "));
  const badge = part(".badge");
  if (badge !== null) setHidden(badge, inProportion);
  setAttribute(cell, "aria-selected", String(chosen));
  cell.classList.toggle("is-starred", note.star);
  cell.classList.toggle("is-hidden", note.hidden);
  cell.classList.toggle("is-playing", state.page.playing.includes(name));
  setAttribute(part("[data-act=star]") ?? cell, "aria-pressed", String(note.star));
  setAttribute(part("[data-act=select]") ?? cell, "aria-pressed", String(chosen));
  put(
    ".card-marks",
    [note.star ? "starred" : "", note.hidden ? "hidden" : ""].filter((word) => word !== "").join(", "),
  );
}

/** The number that the list is sorted by, unless the card shows it already. */
function sortWords(state: AppState, loaded: Loaded, entry: number): string {
  const { sort } = state.page;
  if (sort.by === "alike") {
    const distance = state.distances?.byEntry[entry] ?? NaN;
    return Number.isNaN(distance) ? "" : `${millimetres(distance)} away`;
  }
  if (sort.by !== "number" || sort.number === "log_constraint") return "";
  return `${sort.number} ${number(numberOf(loaded, entry, sort.number))}`;
}

function shareWords({ value, error }: { readonly value: number; readonly error: number | null }): string {
  return `share ${share(value, error)}`;
}

export function groupCard(loaded: Loaded, group: ShownGroup): CardParts {
  const { cell, canvas, box, wordsId } = frame("group");
  const name = loaded.names[group.representative] ?? "";
  canvas.dataset["name"] = name;
  const kept = `${count(group.members.length)} kept`;
  const spread =
    group.members.length === 1 ? "only one animation" : `${millimetres(group.mean_m)} apart on average`;
  const isInProportion = loaded.table.inProportion[group.representative] === 1;
  const plausibility = plausibilityOf(loaded, group.representative);
  const score = numberOf(loaded, group.representative, "log_constraint");
  const scoreWords = Number.isNaN(score) ? "" : `score ${cardNumber(score)}`;
  box.append(
    el(
      "div",
      { class: "card-tools" },
      act("play", `Play ${name}, which represents the group`, iconOf("play")),
      act("like", `Sort by likeness to ${name}`, "≈"),
    ),
    el(
      "div",
      { class: "card-words", id: wordsId },
      ...spaced(
        line(el("strong", { class: "card-kept" }, kept), el("span", { class: "card-name" }, name)),
        line(el("span", {}, spread)),
        el("div", { class: "card-plausibility", title: plausibilityHelp }, plausibility),
        line(
          group.share !== null
            ? el("span", { class: "card-share", title: shareHelp }, shareWords(group.share))
            : isInProportion
              ? el("span", {}, "")
              : el("span", { class: "badge", title: proportionHelp }, badgeWords),
          el("span", { class: "card-score", title: scoreHelp }, scoreWords),
        ),
      ),
    ),
  );
  return { cell, canvas };
}

export function numberOf(loaded: Loaded, entry: number, name: string): number {
  return loaded.table.numbers.get(name)?.[entry] ?? NaN;
}

export function plausibilityOf(loaded: Loaded, entry: number): string {
  // With contact noise, log_prior also depends on the number of impacts.
  if (loaded.table.numbers.has("squares"))
    return ordinaryWords(numberOf(loaded, entry, "squares"), numberOf(loaded, entry, "normals"));
  return plausibilityWords(numberOf(loaded, entry, "log_prior"), loaded.scene.prior_log_prior);
}
