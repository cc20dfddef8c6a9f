// A part of the page: an element, and what brings it up to date when the state has changed.
import type { GallerySource } from "../data/source";
import type { AppState } from "../state/app-state";
import type { Loading } from "../state/loading";
import type { NoteKeeping } from "../state/note-keeping";
import type { PageActions } from "../state/page-actions";
import type { Store } from "../state/store";
import type { Theme } from "./theme";

export interface Part {
  readonly element: HTMLElement;
  /** `before` is the state that was shown; the same as `state` at the first call. */
  update(state: AppState, before: AppState): void;
}

/** What parts act through. */
export interface Ui {
  readonly store: Store<AppState>;
  readonly source: GallerySource;
  readonly loading: Loading;
  readonly page: PageActions;
  readonly notes: NoteKeeping;
  readonly theme: Theme;
}
