// Filters animations by a person's notes: starred, tagged or hidden.
import type { AppState } from "../state/app-state";
import { hiddenCount } from "../state/derived";
import { tagsOf } from "../state/notes";
import type { NotesFilter } from "../state/page";
import { el, field, select, setChoices } from "./dom";
import type { Part, Ui } from "./part";
import { count } from "./words";

export function makeNotesFilter(ui: Ui): Part {
  const change = (parts: Partial<NotesFilter>): void =>
    ui.page.change({ notesFilter: { ...ui.store.state.page.notesFilter, ...parts } });
  const star = el("input", {
    type: "checkbox",
    id: "only-starred",
    on: { change: () => change({ star: star.checked }) },
  });
  const tag = select([], "", (value) => change({ tag: value }), { id: "filter-tag" });
  const hidden = select([], "without", (value) => change({ hidden: value as NotesFilter["hidden"] }), {
    id: "filter-hidden",
  });
  const update = (state: AppState, before: AppState): void => {
    const { notesFilter } = state.page;
    if (
      state !== before &&
      state.notes === before.notes &&
      notesFilter === before.page.notesFilter &&
      state.visible === before.visible
    )
      return;
    star.checked = notesFilter.star;
    const tags = new Set([...tagsOf(state.notes), ...(notesFilter.tag === "" ? [] : [notesFilter.tag])]);
    const choices = [
      { value: "", label: "Any" },
      ...[...tags].map((value) => ({ value, label: value })),
    ];
    if (document.activeElement !== tag) setChoices(tag, choices, notesFilter.tag);
    const many = count(hiddenCount(state));
    if (document.activeElement !== hidden) {
      setChoices(
        hidden,
        [
          { value: "without", label: `Don't show (${many})` },
          { value: "with", label: "Show" },
          { value: "only", label: "Show only these" },
        ],
        notesFilter.hidden,
      );
    }
    hidden.value = notesFilter.hidden;
    tag.value = notesFilter.tag;
  };
  return {
    element: el(
      "section",
      { class: "notes-filter", "aria-label": "Filter by notes" },
      el("h2", {}, "Filter by notes"),
      el("div", { class: "check" }, star, el("label", { for: "only-starred" }, "Only starred")),
      field("Tag", tag),
      field("Hidden animations", hidden),
    ),
    update,
  };
}
