// Wraps the source for the page's parts. If another run's archive replaces the shown one, names and entries
// mean other animations, so all requests fail.
import { SourceError, type GallerySource } from "../data/source";
import type { AppState } from "./app-state";
import { replacing } from "./derived";
import type { Store } from "./store";

export function ofShownRun(source: GallerySource, store: Store<AppState>): GallerySource {
  const refuseOther = (): void => {
    const other = replacing(store.state);
    if (other === null) return;
    throw new SourceError(
      "missing",
      `${other.name} now contains another run.`,
      "Only data that this page has loaded is available.",
    );
  };
  const ask = async <Answer>(question: () => Promise<Answer>): Promise<Answer> => {
    refuseOther();
    const answer = await question();
    // The archive may have been replaced during the request.
    refuseOther();
    return answer;
  };
  return {
    isLive: source.isLive,
    gallery: (options) => source.gallery(options),
    scene: (...of) => ask(() => source.scene(...of)),
    looks: (...of) => ask(() => source.looks(...of)),
    table: (...of) => ask(() => source.table(...of)),
    animations: (...of) => ask(() => source.animations(...of)),
    find: (...of) => ask(() => source.find(...of)),
    groups: (...of) => ask(() => source.groups(...of)),
    alike: (...of) => ask(() => source.alike(...of)),
    seriesTitles: (...of) => ask(() => source.seriesTitles(...of)),
    series: (...of) => ask(() => source.series(...of)),
    diagnosis: (...of) => ask(() => source.diagnosis(...of)),
    // Notes are stored by run.
    notes: (options) => source.notes(options),
    changeNotes: (...of) => source.changeNotes(...of),
    onChange: (listener) => source.onChange(listener),
  };
}
