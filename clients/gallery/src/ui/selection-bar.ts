// Actions for the selected animations. The bar is shown beneath the wall while animations are selected.
import type { AppState } from "../state/app-state";
import { noteOf } from "../data/note-patch";
import { tagsOf } from "../state/notes";
import { comparedMax } from "../state/selection";
import { button, el, setHidden, setText } from "./dom";
import { makeExportHint } from "./export-hint";
import type { Part, Ui } from "./part";
import { counted } from "./words";

/** Delay before the bar appears. Without it, the bar would move a card between a double-click's clicks. */
const doubleClickMs = 400;

export function makeSelectionBar(ui: Ui): Part {
  const chosen = (): readonly string[] => ui.store.state.selection.names;
  const words = el("p", { class: "selection-words", id: "selection-words" });
  const compare = button("Compare", () => ui.page.play(chosen()), {
    id: "compare",
    class: "primary",
    title: `Play up to ${comparedMax} side by side (c)`,
  });
  const star = button("Star", () => ui.notes.toggle(chosen(), "star"), {
    id: "star-chosen",
    title: "Star (s)",
  });
  const hide = button("Hide", () => ui.notes.toggle(chosen(), "hidden"), {
    id: "hide-chosen",
    title: "Hide (h)",
  });
  const tags = el("datalist", { id: "known-tags" });
  const tag = el("input", {
    type: "text",
    id: "tag-chosen",
    "aria-label": "Tag for the selected animations",
    placeholder: "tag",
    list: "known-tags",
    maxlength: 60,
  });
  const putTag = (): void => {
    const text = tag.value.trim().replaceAll(",", " ");
    if (text === "") return;
    ui.notes.toggleTag(chosen(), text);
    tag.value = "";
  };
  tag.addEventListener("keydown", (event) => {
    if (event.key === "Enter") putTag();
  });
  const exportHint = makeExportHint(ui, (state) => state.selection.names, "export-chosen");
  const element = el(
    "section",
    { class: "selection-bar", id: "selection-bar", "aria-label": "Selected animations" },
    words,
    el(
      "div",
      { class: "buttons" },
      compare,
      star,
      hide,
      tag,
      tags,
      button("Tag", putTag, { id: "put-tag" }),
      button("Most similar first", () => ui.page.sortByLikeness(chosen(), false), {
        id: "more-like",
        title: "Sort by likeness to the selected animations (m)",
      }),
      button("Least similar first", () => ui.page.sortByLikeness(chosen(), true), {
        id: "unlike",
        title: "Sort by likeness to the selected animations, least similar first (u)",
      }),
      button("Clear selection", () => ui.page.selectNone(), {
        id: "choose-none",
        title: "Clear selection (Escape)",
      }),
    ),
    exportHint.element,
  );
  let coming: ReturnType<typeof setTimeout> | undefined;
  const update = (state: AppState, before: AppState): void => {
    const { names } = state.selection;
    if (names.length === 0) {
      clearTimeout(coming);
      coming = undefined;
      setHidden(element, true);
    } else if (element.hidden) {
      coming ??= setTimeout(() => {
        coming = undefined;
        setHidden(element, false);
      }, doubleClickMs);
    }
    const shown = names.length <= 4 ? names.join(", ") : `${names.slice(0, 3).join(", ")} …`;
    setText(
      words,
      names.length === 0 ? "" : `${counted(names.length, "animation", "animations")} selected: ${shown}`,
    );
    setText(compare, names.length === 1 ? "Play" : "Compare");
    const isAll = (key: "star" | "hidden"): boolean =>
      names.length > 0 && names.every((name) => noteOf(state.notes, name)[key]);
    setText(star, isAll("star") ? "Unstar" : "Star");
    setText(hide, isAll("hidden") ? "Unhide" : "Hide");
    if (state === before || state.notes !== before.notes)
      tags.replaceChildren(...tagsOf(state.notes).map((value) => el("option", { value })));
    exportHint.update(state, before);
  };
  return { element, update };
}
