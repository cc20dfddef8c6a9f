// Splits long work into parts and lets the page run between them.
//
// Saved pages may be opened from files, for which browsers don't allow workers. So the search runs in the
// page's own thread, some milliseconds at a time.

import { SourceError } from "../data/source";

/** Maximum work between two turns of the page: a small part of a frame. */
const WORK_MS = 10;

export class Turns {
  private begun = performance.now();

  constructor(private readonly signal?: AbortSignal) {}

  /** Whether the present part has taken long enough. */
  isDue(): boolean {
    return performance.now() - this.begun >= WORK_MS;
  }

  /** Lets the page run. Throws SourceError("aborted") if the request was cancelled. */
  async take(): Promise<void> {
    await pageTurn();
    if (this.signal?.aborted) throw new SourceError("aborted", "The request was cancelled.");
    this.begun = performance.now();
  }
}

/** A message arrives after everything that waits already and, unlike a timer, without delay. */
function pageTurn(): Promise<void> {
  return new Promise((resolve) => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = () => {
      port1.close();
      resolve();
    };
    port2.postMessage(null);
  });
}
