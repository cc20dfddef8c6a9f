// Long work in parts: between two of them the page has its turn.
//
// A saved page may be opened from a file, where browsers give it no worker of its own; so its search
// runs beside all else, some milliseconds at a time.

import { SourceError } from "../data/source";

/** Work between two turns of the page: a small part of what a frame may take. */
const WORK_MS = 10;

export class Turns {
  private begun = performance.now();

  constructor(private readonly signal?: AbortSignal) {}

  /** Whether the work has gone on for long enough. */
  isDue(): boolean {
    return performance.now() - this.begun >= WORK_MS;
  }

  /** Lets the page go on. Throws SourceError("aborted") where the answer is no longer wanted. */
  async take(): Promise<void> {
    await pageTurn();
    if (this.signal?.aborted) throw new SourceError("aborted", "The request was cancelled.");
    this.begun = performance.now();
  }
}

/** A message comes back after what waits already, and, other than a timer, without a pause. */
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
