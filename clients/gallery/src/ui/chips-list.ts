// The list of applied queries (chips). A person can switch a chip on or off, negate, edit or delete it. A
// chip shows how many animations match it alone, and how many are left with all chips.
import type { AppState } from "../state/app-state";
import { countsOf } from "../state/derived";
import type { Chip } from "../state/page";
import { button, el, iconButton } from "./dom";
import type { Part, Ui } from "./part";
import { count } from "./words";

export function makeChipsList(ui: Ui, edit: (chip: Chip) => void): Part {
  const list = el("ul", { class: "chips", id: "chips" });
  const none = el("p", { class: "hint" }, "No queries applied.");
  const element = el(
    "section",
    { "aria-label": "Applied queries" },
    el("h2", {}, "Queries"),
    none,
    list,
  );
  const update = (state: AppState, before: AppState): void => {
    const isSame =
      state.page.chips === before.page.chips &&
      state.answers === before.answers &&
      state.visible === before.visible &&
      state.notes === before.notes &&
      state.page.notesFilter === before.page.notesFilter;
    if (isSame && state !== before) return;
    none.hidden = state.page.chips.length > 0;
    const focused = document.activeElement?.getAttribute("data-focus");
    list.replaceChildren(...state.page.chips.map((chip) => chipItem(ui, state, chip, edit)));
    // The focused element was replaced: focus the new one.
    if (focused) list.querySelector<HTMLElement>(`[data-focus="${CSS.escape(focused)}"]`)?.focus();
  };
  return { element, update };
}

function chipItem(ui: Ui, state: AppState, chip: Chip, edit: (chip: Chip) => void): HTMLElement {
  const { alone, asIn, asNot } = countsOf(state, chip.text, chip.id);
  const left = chip.isNot ? asNot : asIn;
  const error = state.answers.get(chip.text)?.error;
  const counts = error
    ? `invalid: ${error.message}`
    : alone === null
      ? "counting …"
      : `matches ${count(alone)}; ${count(left ?? 0)} ${chip.isOn ? "left" : "would be left"}`;
  const change = (parts: Partial<Chip>, words: string) => (): void =>
    ui.page.changeChip(chip.id, parts, `${words}: ${chip.text}`);
  return el(
    "li",
    { class: `chip${chip.isOn ? "" : " chip-off"}${chip.isNot ? " chip-not" : ""}` },
    el(
      "div",
      { class: "chip-line" },
      button(chip.isNot ? "NOT IN" : "IN", change({ isNot: !chip.isNot }, "negated"), {
        class: "chip-sign",
        title: "Keep or remove matching animations",
        "aria-label": `${chip.isNot ? "NOT IN" : "IN"}: ${chip.text}. Negate`,
        "data-focus": `sign-${chip.id}`,
      }),
      el("code", { class: "chip-text" }, chip.text),
    ),
    el(
      "div",
      { class: "chip-line" },
      el("span", { class: `chip-counts${error ? " chip-error" : ""}` }, counts),
      button(
        chip.isOn ? "On" : "Off",
        change({ isOn: !chip.isOn }, chip.isOn ? "switched off" : "switched on"),
        {
          "aria-label": `${chip.isOn ? "On" : "Off"}: ${chip.text}. Switch ${chip.isOn ? "off" : "on"}`,
          class: chip.isOn ? "small is-on" : "small",
          "data-focus": `on-${chip.id}`,
        },
      ),
      iconButton("pencil", `Edit ${chip.text}`, () => edit(chip), { "data-focus": `edit-${chip.id}` }),
      iconButton("close", `Delete ${chip.text}`, () => ui.page.removeChip(chip.id), {
        "data-focus": `remove-${chip.id}`,
      }),
    ),
  );
}
