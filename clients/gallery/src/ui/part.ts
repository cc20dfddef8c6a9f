// A part of the page: an element and a function that updates it when the state changes.
import type { GallerySource } from "../data/source";
import type { AppState } from "../state/app-state";
import type { Loading } from "../state/loading";
import type { NoteKeeping } from "../state/note-keeping";
import type { PageActions } from "../state/page-actions";
import type { Store } from "../state/store";
import type { Theme } from "./theme";

export interface Part {
  readonly element: HTMLElement;
  /** `before` is the state that the part last showed; the first call passes `state` twice. */
  update(state: AppState, before: AppState): void;
}

/** What parts use to read and change the page. */
export interface Ui {
  readonly store: Store<AppState>;
  readonly source: GallerySource;
  readonly loading: Loading;
  readonly page: PageActions;
  readonly notes: NoteKeeping;
  readonly theme: Theme;
}
