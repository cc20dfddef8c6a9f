// The panel beside the wall: queries, the builder, filters by notes.
import type { Part, Ui } from "./part";
import { makeBuilder } from "./builder";
import { makeChipsList } from "./chips-list";
import { el } from "./dom";
import { makeNotesFilter } from "./notes-filter";
import { makeQueryBox } from "./query-box";

export interface FiltersPanel extends Part {
  focusQuery(): void;
}

export function makeFiltersPanel(ui: Ui): FiltersPanel {
  const query = makeQueryBox(ui);
  const chips = makeChipsList(ui, (chip) => query.edit(chip.text, chip.id));
  const builder = makeBuilder(ui);
  const notes = makeNotesFilter(ui);
  const parts = [chips, query, builder, notes];
  return {
    element: el(
      "aside",
      { class: "filters", id: "filters", "aria-label": "Filters" },
      ...parts.map(({ element }) => element),
    ),
    update(state, before) {
      for (const part of parts) part.update(state, before);
    },
    focusQuery() {
      query.element.querySelector("textarea")?.focus();
    },
  };
}
