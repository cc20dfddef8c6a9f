// The command that exports the selected animations, with a warning if their draws aren't in proportion.
import type { AppState } from "../state/app-state";
import { archiveShown, replacing, signedQueries } from "../state/derived";
import { exportLine } from "../state/export-line";
import { proportionHelp } from "../state/plausibility";
import { copyText } from "./copying";
import { button, el, setHidden, setText } from "./dom";
import type { Part, Ui } from "./part";

export function makeExportHint(ui: Ui, namesOf: (state: AppState) => readonly string[], id: string): Part {
  const line = el("code", {
    class: "export-line",
    id,
    tabindex: 0,
    role: "textbox",
    "aria-readonly": "true",
    "aria-label": "Export command",
  });
  const copy = button("Copy the command", () => void copyText(ui.store, line.textContent ?? "", "Command"), {
    class: "small",
  });
  const proportion = el("p", { class: "hint" }, proportionHelp);
  const update = (state: AppState): void => {
    const archive = replacing(state) === null ? archiveShown(state) : null;
    const names = namesOf(state);
    const { loaded } = state;
    setText(line, exportLine(archive?.name ?? "archive.h5", names, signedQueries(state.page.chips)));
    // Names that aren't in the archive are skipped.
    const entries = names.flatMap((name) => loaded?.entryOf.get(name) ?? []);
    const all = entries.every((entry) => loaded?.table.inProportion[entry] === 1);
    setHidden(proportion, all);
  };
  return {
    element: el(
      "details",
      { class: "export" },
      el("summary", {}, "Export"),
      el("p", { class: "hint" }, "Run this command to write 3D models, tables, images or videos:"),
      line,
      copy,
      proportion,
    ),
    update,
  };
}
