// The page's area for plots. The code that draws plots is loaded when a person first opens them.
import type { AppState } from "../state/app-state";
import { sentenceOf } from "../state/messages";
import { Latest } from "../state/store";
import { el, setHidden, setText } from "./dom";
import type { Part, Ui } from "./part";

export function makePlotsFrame(ui: Ui): Part {
  const place = el("div", { class: "plots-place" });
  const words = el("p", { class: "empty" });
  const element = el(
    "section",
    { class: "plots", id: "plots", "aria-label": "Plots", hidden: true },
    words,
    place,
  );
  const latest = new Latest();
  let view: Part | null = null;
  const begin = async (): Promise<void> => {
    const isWanted = latest.begin();
    setText(words, "Loading plots …");
    setHidden(words, false);
    try {
      const { makePlotsView } = await import("../plots/plots-view");
      if (!isWanted() || view !== null) return;
      view = makePlotsView(ui);
      place.append(view.element);
      setHidden(words, true);
      view.update(ui.store.state, ui.store.state);
    } catch (error) {
      setText(words, `Cannot load plots: ${sentenceOf(error)}`);
    }
  };
  const update = (state: AppState, before: AppState): void => {
    const isShown = state.page.view === "plots";
    setHidden(element, !isShown);
    if (!isShown) return;
    if (view === null && (state === before || before.page.view !== "plots")) void begin();
    else view?.update(state, before);
  };
  return { element, update };
}
