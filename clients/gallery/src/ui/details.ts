// Details of one animation in the player: its numbers, its events as text, and a person's notes.
import type { AppState } from "../state/app-state";
import { emptyNote, noteOf } from "../data/note-patch";
import { tagsOfText } from "../state/notes";
import { plausibilityHelp, proportionHelp, scoreHelp } from "../state/plausibility";
import type { TimelineItem } from "../view/timeline";
import { button, el, field, select, setChoices, setHidden, setText } from "./dom";
import { numberOf, plausibilityOf } from "./card";
import type { Part, Ui } from "./part";
import { count, seconds, withUnit } from "./words";

/** Maximum length of the event list, which keeps the page responsive. */
const eventsShownMax = 1000;

export interface Details extends Part {
  /** Updates the details for the player's animations. `items` has the order of page.playing. */
  show(items: readonly TimelineItem[]): void;
  /** Index of the animation whose details are shown. */
  readonly chosen: number;
}

export function makeDetails(ui: Ui, seek: (sharedS: number) => void): Details {
  let items: readonly TimelineItem[] = [];
  let chosen = 0;
  const nameNow = (): string => ui.store.state.page.playing[chosen] ?? "";
  const which = select(
    [],
    "0",
    (value) => {
      chosen = Number(value);
      redraw(ui.store.state);
    },
    { id: "details-of" },
  );
  const whichField = field("Details of", which);
  const plausibility = el("p", { class: "details-plausibility" });
  const proportion = el("p", { class: "hint proportion", id: "player-proportion" }, proportionHelp);
  const numbers = el("tbody");
  const events = el("ol", { class: "events" });
  const eventsBox = el(
    "details",
    { class: "events-box", id: "events", on: { toggle: () => listEvents() } },
    el("summary", {}, "Events"),
    events,
  );
  const note = makeNoteEditor(ui, nameNow);

  const listEvents = (): void => {
    if (!eventsBox.open) {
      events.replaceChildren();
      return;
    }
    const all = items[chosen]?.events ?? [];
    const shown = all.slice(0, eventsShownMax).map((event) =>
      el(
        "li",
        {},
        button(`${seconds(event.timeS)}  ${event.words}`, () => seek(event.sharedS), { class: "link" }),
      ),
    );
    const more = all.length - shown.length;
    events.replaceChildren(...shown, ...(more > 0 ? [el("li", {}, `${count(more)} more events`)] : []));
  };
  const redraw = (state: AppState): void => {
    const { loaded } = state;
    const name = nameNow();
    const entry = loaded?.entryOf.get(name);
    setHidden(whichField, state.page.playing.length < 2);
    if (loaded === null || entry === undefined) {
      numbers.replaceChildren();
      setText(plausibility, "");
      setHidden(proportion, true);
      return;
    }
    const words = plausibilityOf(loaded, entry);
    setText(plausibility, words === "" ? name : `${name}: ${words}.`);
    plausibility.title = plausibilityHelp;
    setHidden(proportion, loaded.table.inProportion[entry] === 1);
    const rows = loaded.scene.numbers.map(({ name: of, unit }) =>
      numberRow(of, withUnit(numberOf(loaded, entry, of), unit)),
    );
    numbers.replaceChildren(...rows);
    note.show(state, name);
    listEvents();
  };
  return {
    element: el(
      "div",
      { class: "details" },
      whichField,
      plausibility,
      proportion,
      note.element,
      el(
        "details",
        { class: "numbers", open: true },
        el("summary", {}, "Numbers"),
        el(
          "table",
          { id: "numbers" },
          el(
            "thead",
            {},
            el("tr", {}, el("th", { scope: "col" }, "Name"), el("th", { scope: "col" }, "Value")),
          ),
          numbers,
        ),
      ),
      eventsBox,
    ),
    get chosen() {
      return chosen;
    },
    show(shown) {
      items = shown;
      const { playing } = ui.store.state.page;
      if (chosen >= playing.length) chosen = 0;
      setChoices(
        which,
        playing.map((label, i) => ({ value: String(i), label })),
        String(chosen),
      );
      redraw(ui.store.state);
    },
    update(state, before) {
      if (state.page.playing !== before.page.playing || state.loaded !== before.loaded) redraw(state);
      else if (state.notes !== before.notes) note.show(state, nameNow());
    },
  };
}

function numberRow(name: string, value: string): HTMLElement {
  const help = name === "log_prior" ? plausibilityHelp : name === "log_constraint" ? scoreHelp : null;
  return el("tr", {}, el("th", { scope: "row", title: help }, name), el("td", {}, value));
}

interface NoteEditor {
  readonly element: HTMLElement;
  show(state: AppState, name: string): void;
}

function makeNoteEditor(ui: Ui, nameNow: () => string): NoteEditor {
  const star = button("Star", () => ui.notes.toggle([nameNow()], "star"), {
    id: "star-playing",
    title: "Star (s)",
  });
  const hide = button("Hide", () => ui.notes.toggle([nameNow()], "hidden"), {
    id: "hide-playing",
    title: "Hide (h)",
  });
  const tags = el("input", {
    type: "text",
    id: "tags-playing",
    placeholder: "red, long throw",
    maxlength: 400,
  });
  const text = el("textarea", { id: "note-playing", rows: 2, maxlength: 4000 });
  // The animation that the fields edit. The player may switch animations before a field loses the focus.
  let of = { run: "", name: "" };
  // The note that was stored when the field got the focus. Later changes by others are merged, not overwritten.
  let before = emptyNote;
  const keepTags = (): void => ui.notes.edit(of.run, of.name, before, { tags: tagsOfText(tags.value) });
  const keepText = (): void => ui.notes.edit(of.run, of.name, before, { note: text.value });
  tags.addEventListener("change", keepTags);
  text.addEventListener("change", keepText);
  // Saves text that is being typed when the page closes, before notes are sent for the last time.
  const leave = (): void => {
    if (document.activeElement === tags && tags.value !== before.tags.join(", ")) keepTags();
    if (document.activeElement === text && text.value !== before.note) keepText();
  };
  window.addEventListener("pagehide", leave, { capture: true });
  return {
    element: el(
      "div",
      { class: "note-editor", role: "group", "aria-label": "Your notes" },
      el("div", { class: "buttons" }, star, hide),
      field("Tags", tags),
      field("Note", text),
    ),
    show(state, name) {
      const note = name === "" ? emptyNote : noteOf(state.notes, name);
      star.setAttribute("aria-pressed", String(note.star));
      hide.setAttribute("aria-pressed", String(note.hidden));
      const run = state.loaded?.run ?? "";
      const isOther = name !== of.name || run !== of.run;
      of = { run, name };
      if (isOther || (document.activeElement !== tags && document.activeElement !== text)) before = note;
      if (isOther || document.activeElement !== tags) tags.value = note.tags.join(", ");
      if (isOther || document.activeElement !== text) text.value = note.note;
    },
  };
}
