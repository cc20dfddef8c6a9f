// The plots of an archive: a list of plots, and the selected plot. A click on a point opens the nearest
// animation of the same chain. Selecting a range of draws filters the wall.
import "uplot/dist/uPlot.min.css";
import type { AppState, Loaded } from "../state/app-state";
import { archiveShown } from "../state/derived";
import { say, sentenceOf } from "../state/messages";
import { Latest } from "../state/store";
import type { Series, SeriesTitle } from "../data/types";
import { button, el, field, select, setChoices, setHidden, setText } from "../ui/dom";
import type { Part, Ui } from "../ui/part";
import { makeBarChart } from "./bar-chart";
import { jsonTable } from "./json-table";
import { makeLineChart, type Chart } from "./line-chart";
import { chainsOf, plotDataOf, type PlotData, type PlotLine } from "./series-data";

const chainsShownMax = 6;
/** The diagnosis is requested separately from other plots. */
const diagnosis = "diagnosis";

export function makePlotsView(ui: Ui): Part {
  const list = el("ul", { class: "plot-list" });
  const notices = el("div", { class: "notices" });
  const title = el("h2", { id: "plot-title" });
  const place = el("div", { class: "plot-place", id: "plot-place" });
  const words = el("p", { class: "empty", id: "plot-words" });
  const latest = new Latest();
  const latestList = new Latest();
  const chain = select([], "", () => void read(ui.store.state), { id: "plot-chain" });
  const chainField = field("Chain", chain);
  let titles: readonly SeriesTitle[] = [];
  let chart: Chart | null = null;
  let shownOf: Loaded | null = null;
  let shownName = "";

  const readList = async (loaded: Loaded): Promise<void> => {
    const isWanted = latestList.begin();
    let found: readonly SeriesTitle[] = [];
    let why = "There are no plots, because the archive has no chains.";
    try {
      found = await ui.source.seriesTitles(loaded.id);
    } catch (error) {
      why = sentenceOf(error);
      if (isWanted()) say(ui.store, why);
    }
    if (!isWanted()) return;
    titles = found;
    showList(ui.store.state);
    if (titles.length > 0) {
      void read(ui.store.state);
      return;
    }
    setText(title, "");
    setHidden(chainField, true);
    setText(words, why);
    setHidden(words, false);
  };
  const chosen = (state: AppState): SeriesTitle | undefined =>
    titles.find(({ name }) => name === state.page.plot) ?? titles[0];
  const showList = (state: AppState): void => {
    const now = chosen(state)?.name;
    const had = list.contains(document.activeElement)
      ? document.activeElement?.getAttribute("data-plot")
      : null;
    let heading = "";
    list.replaceChildren(
      ...titles.flatMap(({ name, title: label, kind }) => {
        const item = el(
          "li",
          {},
          button(label, () => ui.page.change({ plot: name }), {
            class: "tab",
            "aria-current": name === now ? "true" : null,
            "data-plot": name,
          }),
        );
        const isNew = headingOf(kind) !== heading;
        heading = headingOf(kind);
        return isNew ? [el("li", { class: "plot-group" }, heading), item] : [item];
      }),
    );
    // The focused button was replaced: focus the new one.
    for (const made of list.querySelectorAll("button")) if (had && made.dataset["plot"] === had) made.focus();
  };
  const clear = (): void => {
    chart?.dispose();
    chart = null;
    place.replaceChildren();
    notices.replaceChildren();
  };
  const read = async (state: AppState): Promise<void> => {
    const { loaded } = state;
    const isWanted = latest.begin();
    const asked = chosen(state);
    if (loaded === null || asked === undefined) return;
    const { name, title: label, kind } = asked;
    shownName = name;
    setText(title, label);
    offerChains(kind);
    setText(words, "Reading …");
    setHidden(words, false);
    try {
      if (name === diagnosis) {
        const answer = await ui.source.diagnosis(loaded.id);
        if (!isWanted()) return;
        clear();
        place.append(
          el(
            "div",
            { class: "json-table", tabindex: 0, role: "region", "aria-label": label },
            jsonTable(answer),
          ),
        );
      } else {
        const data = plotDataOf(label, kind, await readAll(loaded, name, kind));
        if (!isWanted()) return;
        clear();
        draw(data, loaded);
      }
      setHidden(words, true);
    } catch (error) {
      if (!isWanted()) return;
      clear();
      setText(words, sentenceOf(error));
    }
  };
  /** Traces of all chains share one plot; plots of ladders show one chain. */
  const offerChains = (kind: string): void => {
    const many = archiveShown(ui.store.state)?.chains ?? 1;
    const isOne = ["levels", "rounds", "index"].includes(kind);
    setHidden(chainField, many < 2 || !(isOne || kind === "trace"));
    const all = { value: "", label: many > chainsShownMax ? `first ${chainsShownMax}` : "all" };
    const each = Array.from({ length: many }, (_, i) => ({ value: String(i), label: String(i) }));
    const value = isOne && chain.value === "" ? "0" : chain.value;
    setChoices(chain, isOne ? each : [all, ...each], value);
  };
  /** Reads a trace for each chain, up to the number of lines that people can distinguish. */
  const readAll = async (loaded: Loaded, name: string, kind: string): Promise<Series[]> => {
    const only = chain.value;
    if (kind === "pair") return [await ui.source.series(loaded.id, name)];
    if (kind !== "trace") return [await ui.source.series(loaded.id, name, { chain: only || "0" })];
    if (only !== "") return [await ui.source.series(loaded.id, name, { chain: only })];
    const first = await ui.source.series(loaded.id, name, { chain: "0" });
    const chains = Math.min(chainsOf(first), chainsShownMax);
    const others = Array.from({ length: chains - 1 }, (_, i) =>
      ui.source.series(loaded.id, name, { chain: String(i + 1) }),
    );
    return [first, ...(await Promise.all(others))];
  };
  const draw = (data: PlotData, loaded: Loaded): void => {
    const isDark = ui.theme.shade === "dark";
    const warning = archiveShown(ui.store.state)?.warning ?? "";
    const sentences = [...(warning === "" ? [] : [warning]), ...data.notices];
    notices.replaceChildren(
      ...sentences.map((sentence) => el("p", { class: "warning", role: "note" }, sentence)),
    );
    setText(title, data.title);
    const isOfDraws = data.xIs === "draw";
    chart =
      data.kind === "histograms"
        ? makeBarChart(data, isDark)
        : makeLineChart(data, {
            isDark,
            onPoint: isOfDraws ? (x, line) => openNearest(ui, loaded, x, line) : null,
            onRange: isOfDraws ? (from, to) => filterDraws(ui, from, to) : null,
          });
    place.replaceChildren(chart.element);
  };
  ui.theme.onChange(() => {
    if (chart !== null) void read(ui.store.state);
  });
  return {
    element: el(
      "div",
      { class: "plots-view" },
      el("nav", { "aria-label": "Plots" }, list),
      el("div", { class: "plot" }, notices, title, chainField, words, place),
    ),
    update(state) {
      const { loaded } = state;
      if (loaded === null) return;
      if (shownOf === null || shownOf.id !== loaded.id || shownOf.run !== loaded.run) {
        shownOf = loaded;
        titles = [];
        clear();
        void readList(loaded);
      } else if (chosen(state) !== undefined && chosen(state)?.name !== shownName) {
        showList(state);
        void read(state);
      }
    },
  };
}

function headingOf(kind: string): string {
  const headings: Readonly<Record<string, string>> = {
    trace: "Along the chain",
    levels: "Ladder",
    rounds: "Ladder",
    index: "Ladder",
    pair: "Prior and posterior",
    table: "Diagnosis",
  };
  return headings[kind] ?? "More";
}

/** Opens the kept animation whose draw is nearest, in the line's chain. */
function openNearest(ui: Ui, loaded: Loaded, x: number, line: PlotLine): void {
  const { table, names } = loaded;
  let best = -1;
  let away = Infinity;
  for (const entry of ui.store.state.visible) {
    if (table.isFind[entry] === 1 || (line.chain >= 0 && table.chain[entry] !== line.chain)) continue;
    const distance = Math.abs((table.draw[entry] ?? NaN) - x);
    if (distance < away) {
      away = distance;
      best = entry;
    }
  }
  const name = names[best];
  if (name === undefined) {
    say(ui.store, "This chain has no kept animations.");
    return;
  }
  ui.page.play([name]);
  const distance = away > 0 ? `, ${Math.round(away)} draws away` : "";
  say(ui.store, `Opened ${name}, the kept animation nearest to draw ${Math.round(x)}${distance}.`);
}

function filterDraws(ui: Ui, from: number, to: number): void {
  const text = `draw ${Math.max(0, Math.floor(from))}..${Math.ceil(to)}`;
  ui.page.addChip(text, false);
  say(ui.store, `The wall now shows only ${text}. To undo, delete this query in the filters.`);
}
