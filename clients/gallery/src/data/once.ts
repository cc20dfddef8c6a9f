// What is loaded once and kept: who asks while it is under way waits for the same answer. What failed
// is tried again for the next one who asks, but not at once: who asks anew at each failure would have
// the browser look for a missing file all the time.

interface Held<T> {
  readonly value: Promise<T>;
  bytes: number;
  isHere: boolean;
}

export interface OnceOptions<T> {
  /** Of more bytes together, what was used longest ago goes; the newest one stays. */
  readonly bytesMax?: number;
  readonly bytesOf?: (value: T) => number;
  /** Between a failure and the next try. */
  readonly pauseMs?: number;
}

export class Once<T> {
  /** In the order of last use, the longest ago first. */
  private readonly held = new Map<string, Held<T>>();
  private bytes = 0;

  /** When what failed may be tried again: performance.now(). */
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
