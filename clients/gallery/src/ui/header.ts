// The top of the page: archives, number of animations shown, date of the data, new animations, problems.
import type { ArchiveSummary } from "../data/types";
import { archiveShown, hiddenCount, offeredCount, replacing, within } from "../state/derived";
import type { AppState } from "../state/app-state";
import { button, el, select, setHidden, setText } from "./dom";
import type { Part, Ui } from "./part";
import type { ThemeChoice } from "./theme";
import { count, counted, noPictures } from "./words";

export function makeHeader(ui: Ui, showKeys: () => void, toggleFilters: () => void): Part {
  const archives = el("nav", { class: "archives", "aria-label": "Archives" });
  const counts = el("p", { class: "counts", id: "counts" });
  const live = el("p", { class: "live", id: "live" });
  const fresh = button("", () => ui.loading.takeOffered(), { id: "take-new", class: "primary" });
  const other = button("", () => showArchive(ui, replacing(ui.store.state)), { id: "take-other", class: "primary" });
  const filters = button("Filters", toggleFilters, {
    id: "toggle-filters",
    "aria-controls": "filters",
    "aria-expanded": "false",
    class: "only-narrow",
  });
  const theme = select(
    [
      { value: "system", label: "System" },
      { value: "light", label: "Light" },
      { value: "dark", label: "Dark" },
    ],
    ui.theme.choice,
    (value) => ui.theme.choose(value as ThemeChoice),
    { id: "theme", "aria-label": "Colour theme", title: "Colour theme" },
  );
  const keys = button("Keys", showKeys, { id: "show-keys", title: "Keys (?)" });
  const warning = el("div", { class: "warning", id: "warning", role: "note" });
  const trouble = el("div", { class: "trouble", id: "trouble" });
  const element = el(
    "header",
    { class: "header" },
    el(
      "div",
      { class: "header-line" },
      el("h1", { class: "title" }, "sleight gallery"),
      archives,
      el("div", { class: "header-tools" }, filters, theme, keys),
    ),
    warning,
    trouble,
    el("div", { class: "header-line counts-line" }, counts, live, fresh, other),
  );
  const update = (state: AppState, before: AppState): void => {
    if (
      state.gallery !== before.gallery ||
      state.loaded !== before.loaded ||
      archives.childElementCount === 0
    )
      archives.replaceChildren(...archiveTabs(ui, state));
    const archive = archiveShown(state);
    setText(counts, countWords(state));
    setText(live, archive?.is_live ? archive.live_words || "The run is in progress." : "");
    const offered = offeredCount(state);
    setHidden(fresh, offered === 0);
    const offer = `${count(offered)} ${state.isBeginning ? "more" : "new"}`;
    setText(fresh, offer);
    fresh.setAttribute("aria-label", `Show ${offer}`);
    const replaced = replacing(state);
    setHidden(other, replaced?.state !== "ready");
    setText(other, replaced === null ? "" : `Show the new run in ${replaced.name}`);
    setText(warning, archive?.warning ? `Warning: ${archive.warning}` : "");
    setHidden(warning, !archive?.warning);
    const words = troubleWords(state, archive);
    setText(trouble, words);
    setHidden(trouble, words === "");
  };
  return { element, update };
}

function showArchive(ui: Ui, archive: ArchiveSummary | null): void {
  if (archive === null) return;
  const all = ui.store.state.gallery?.archives ?? [];
  const isAlone = archive.run !== "" && all.filter(({ run }) => run === archive.run).length === 1;
  ui.page.showArchive(archive.run, isAlone ? "" : archive.name);
}

/** Archives are tabs, or a drop-down list if there are many. */
function archiveTabs(ui: Ui, state: AppState): HTMLElement[] {
  const all = state.gallery?.archives ?? [];
  const shown = state.loaded?.id ?? -1;
  const tabsMax = 4;
  const show = (archive: ArchiveSummary | undefined): void => showArchive(ui, archive ?? null);
  if (all.length > tabsMax) {
    const choices = all.map((archive) => ({ value: String(archive.id), label: archiveWords(archive) }));
    const chosen = (id: string): void => show(all.find((archive) => String(archive.id) === id));
    return [select(choices, String(shown), chosen, { "aria-label": "Archive", id: "archive" })];
  }
  return all.map((archive) =>
    button(archiveWords(archive), () => show(archive), {
      class: "tab",
      "aria-current": archive.id === shown ? "page" : null,
      title: `${archive.world}, ${archive.method}; run ${archive.run}`,
    }),
  );
}

function archiveWords(archive: ArchiveSummary): string {
  const reading =
    archive.reading === null ? "" : ` ${count(archive.reading.done)} of ${count(archive.reading.of)}`;
  const beingRead = ` (reading${reading})`;
  const states = {
    ready: archive.is_beginning ? beingRead : "", reading: beingRead, gone: " (missing)", damaged: " (damaged)",
  };
  return `${archive.name}${states[archive.state]}`;
}

function countWords(state: AppState): string {
  if (state.loaded === null) return state.loadFailure || "Reading the archive …";
  const hidden = hiddenCount(state);
  const shown = `${count(within(state).length)} of ${count(state.visible.length)} shown`;
  const isLeftOut = hidden > 0 && state.page.notesFilter.hidden === "without";
  return `${shown}${isLeftOut ? `, ${count(hidden)} hidden by you` : ""} · as of ${state.asOf}`;
}

function troubleWords(state: AppState, archive: ArchiveSummary | null): string {
  const sentences: string[] = [];
  if (state.source === "away")
    sentences.push(
      "The server doesn't answer. Loaded data stays visible, and the page reconnects automatically.",
    );
  if (state.source === "refused")
    sentences.push("The server no longer accepts this page. Open the link that the server prints.");
  if (archive?.state === "gone")
    sentences.push(archive.words || `${archive.name} no longer exists; loaded data stays visible.`);
  if (archive?.state === "damaged")
    sentences.push(archive.words || `${archive.name} is damaged; loaded data stays visible.`);
  if (state.hasNoPictures) sentences.push(noPictures);
  const other = replacing(state);
  if (other !== null)
    sentences.push(
      `${other.name} now contains another run. Loaded data of run ${state.loaded?.run.slice(0, 8) ?? ""} stays visible. ` +
        "Queries, groups, plots and animations of that run can no longer be loaded.",
    );
  const notes = state.gallery?.notes;
  if (notes !== undefined && !notes.writable) sentences.push(notes.words);
  else if (state.notesWords !== "") sentences.push(state.notesWords);
  const left = state.gallery?.left_out ?? [];
  if (left.length > 0) {
    const reasons = left
      .slice(0, 3)
      .map(({ name, reason }) => `${name}: ${reason}`)
      .join("; ");
    const more = left.length > 3 ? "; …" : "";
    sentences.push(`${counted(left.length, "file was", "files were")} skipped (${reasons}${more}).`);
  }
  return sentences.join(" ");
}
