// A cache of loaded values. Concurrent requests for one key share one load. A failed load is repeated at the
// next request after a pause, so that a missing file isn't requested all the time.

interface Held<T> {
  readonly value: Promise<T>;
  bytes: number;
  isHere: boolean;
}

export interface OnceOptions<T> {
  /** Maximum bytes of all values. Above it, the least recently used values are dropped; the newest stays. */
  readonly bytesMax?: number;
  readonly bytesOf?: (value: T) => number;
  /** Minimum pause between a failure and the next load. */
  readonly pauseMs?: number;
}

export class Once<T> {
  /** From least to most recently used. */
  private readonly held = new Map<string, Held<T>>();
  private bytes = 0;

  /** Earliest time of the next load after a failure, as performance.now(). */
  private readonly failed = new Map<string, number>();

  constructor(private readonly options: OnceOptions<T> = {}) {}

  get(key: string, make: () => Promise<T>): Promise<T> {
    const found = this.held.get(key);
    if (found !== undefined) {
      this.held.delete(key);
      this.held.set(key, found);
      return found.value;
    }
    const one: Held<T> = { value: this.made(key, make), bytes: 0, isHere: false };
    this.held.set(key, one);
    one.value.then(
      (value) => {
        one.isHere = true;
        one.bytes = this.options.bytesOf?.(value) ?? 0;
        this.bytes += one.bytes;
        this.trim(key);
      },
      () => {
        this.held.delete(key);
        this.failed.set(key, performance.now() + (this.options.pauseMs ?? 0));
      },
    );
    return one.value;
  }

  private async made(key: string, make: () => Promise<T>): Promise<T> {
    const pauseMs = (this.failed.get(key) ?? 0) - performance.now();
    if (pauseMs > 0) await new Promise((resolve) => setTimeout(resolve, pauseMs));
    this.failed.delete(key);
    return make();
  }

  private trim(newest: string): void {
    const bytesMax = this.options.bytesMax ?? Infinity;
    for (const [key, { bytes, isHere }] of this.held) {
      if (this.bytes <= bytesMax) return;
      if (!isHere || key === newest) continue;
      this.held.delete(key);
      this.bytes -= bytes;
    }
  }
}
