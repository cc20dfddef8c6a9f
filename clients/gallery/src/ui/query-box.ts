// The query as text. Matches are counted while a person types; errors are marked at their column.
import { countsOf } from "../state/derived";
import type { AppState, Loaded } from "../state/app-state";
import { placeOfColumn, quotedName } from "../state/query-text";
import { button, el, field, setHidden, setText } from "./dom";
import type { Part, Ui } from "./part";
import { count } from "./words";

const draftDelayMs = 180;

export interface QueryBox extends Part {
  /** Puts a query into the field for editing. `id` is its chip, or null for a new query. */
  edit(text: string, id: number | null): void;
}

export function makeQueryBox(ui: Ui): QueryBox {
  const input = el("textarea", {
    id: "query",
    rows: 2,
    spellcheck: "false",
    autocomplete: "off",
    autocapitalize: "off",
    "aria-describedby": "query-error query-help",
  });
  const error = el("div", { class: "query-error", id: "query-error" });
  const addIn = button("Keep matching", () => apply(false), { id: "query-in", class: "primary" });
  const addNot = button("Remove matching", () => apply(true), { id: "query-not" });
  const words = el("p", { class: "hint", id: "query-count" });
  let edited: number | null = null;
  let timer: ReturnType<typeof setTimeout> | undefined;

  const textNow = (): string => input.value.trim();
  const putDraft = (): void => {
    clearTimeout(timer);
    ui.store.set({ draft: textNow() });
  };
  const apply = (isNot: boolean): void => {
    const text = textNow();
    putDraft();
    if (text === "" || ui.store.state.answers.get(text)?.error) return;
    if (edited === null) ui.page.addChip(text, isNot);
    else ui.page.changeChip(edited, { text, isNot, isOn: true }, `edited: ${text}`);
    edited = null;
    input.value = "";
    putDraft();
    input.focus();
  };
  input.addEventListener("input", () => {
    clearTimeout(timer);
    timer = setTimeout(putDraft, draftDelayMs);
  });
  input.addEventListener("keydown", (event) => {
    if (event.key === "Enter" && !event.shiftKey) {
      event.preventDefault();
      apply(event.altKey);
    } else if (event.key === "Escape") {
      // Escape first cancels editing of a chip, then leaves the field. Escape in the field doesn't reach the
      // page.
      event.stopPropagation();
      if (edited === null) {
        input.blur();
        return;
      }
      edited = null;
      input.value = "";
      putDraft();
    }
  });

  const update = (state: AppState, before: AppState): void => {
    input.placeholder = exampleOf(state.loaded);
    const isSame =
      state.draft === before.draft &&
      state.answers === before.answers &&
      state.page.chips === before.page.chips &&
      state.visible === before.visible &&
      state.notes === before.notes;
    if (isSame && state !== before) return;
    const text = textNow();
    const isAsked = text !== "" && text === state.draft;
    const wrong = isAsked ? (state.answers.get(text)?.error ?? null) : null;
    showError(error, text, wrong);
    input.setAttribute("aria-invalid", String(wrong !== null));
    const counts = isAsked ? countsOf(state, text, edited) : null;
    const known = counts !== null && counts.asIn !== null && counts.asNot !== null;
    setText(addIn, known ? `Keep matching: ${count(counts.asIn ?? 0)} left` : "Keep matching");
    setText(addNot, known ? `Remove matching: ${count(counts.asNot ?? 0)} left` : "Remove matching");
    addIn.disabled = text === "" || wrong !== null;
    addNot.disabled = addIn.disabled;
    setText(
      words,
      isAsked && counts?.alone != null
        ? `Alone, the query matches ${count(counts.alone)} of ${count(state.visible.length)}.`
        : "",
    );
  };
  const element = el(
    "section",
    { class: "query-box", "aria-label": "Query as text" },
    field("Query", input),
    error,
    words,
    el("div", { class: "buttons" }, addIn, addNot),
    el(
      "p",
      { class: "hint", id: "query-help" },
      "Enter keeps matching animations; Alt+Enter removes them; Escape leaves the field. " +
        "Join conditions with and, or, not, then.",
    ),
  );
  return {
    element,
    update,
    edit(text, id) {
      edited = id;
      input.value = text;
      putDraft();
      input.focus();
    },
  };
}

/** An example query with the archive's first body. */
function exampleOf(loaded: Loaded | null): string {
  const [first] = loaded?.scene.features ?? [];
  return `${first?.kind === "body" ? quotedName(first.name) : "any"} in x 0..20mm during 0.4..0.6s`;
}

/** Shows the query's line with a mark at the error, and the error's message. */
function showError(
  element: HTMLElement,
  text: string,
  error: { readonly column: number; readonly message: string } | null,
): void {
  setHidden(element, error === null);
  if (error === null) {
    element.replaceChildren();
    return;
  }
  const place = placeOfColumn(text, error.column);
  const about = 24;
  const begin = Math.max(0, place - about);
  const line = el(
    "code",
    { class: "query-error-text" },
    `${begin > 0 ? "…" : ""}${text.slice(begin, place)}`,
    el("mark", {}, text.slice(place, place + 1) || " "),
    text.slice(place + 1, place + about),
  );
  element.replaceChildren(line, el("p", {}, `Column ${error.column}: ${error.message}`));
}
