// Keeps the page's address equal to its state. Changes that a person may want to undo with "back" add an
// entry to the browser's history. Changes of time, camera and selection replace the current entry.
import type { AppState } from "./app-state";
import { linkOf, placeOf } from "./link";
import type { Page } from "./page";
import type { Store } from "./store";

/** Browsers refuse more than some hundred changes of the address in 30 seconds. */
const replaceDelayMs = 300;

export class Address {
  private place = "";
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly store: Store<AppState>,
    private readonly apply: (link: string) => void,
  ) {}

  start(): void {
    this.place = placeOf(this.store.state.page);
    this.store.subscribe((state) => this.follow(state));
    window.addEventListener("popstate", () => {
      clearTimeout(this.timer);
      this.apply(location.hash);
      this.place = placeOf(this.store.state.page);
    });
  }

  private follow(state: AppState): void {
    const place = placeOf(state.page);
    const isStep = place !== this.place;
    // Filling in the run at the start doesn't add to the history.
    const isFirst = isStep && placeOf({ ...state.page, run: "" }) === this.place;
    this.place = place;
    clearTimeout(this.timer);
    if (isStep && !isFirst) history.pushState(null, "", `#${linkOf(linkPage(state))}`);
    else this.timer = setTimeout(() => this.replace(), replaceDelayMs);
  }

  private replace(): void {
    const link = `#${linkOf(linkPage(this.store.state))}`;
    if (link !== location.hash) history.replaceState(null, "", link);
  }
}

export function linkPage(state: AppState): Page {
  return { ...state.page, selected: state.selection.names };
}
