// A plain store: one immutable state, replaced as a whole; listeners compare the parts that they
// show with what was there before. All that is told at once is told in one turn of the event loop,
// so that five changes in a row draw the page once.

export type Listener<State> = (state: State, before: State) => void;

export class Store<State extends object> {
  private current: State;
  private told: State;
  private isTelling = false;
  private readonly listeners = new Set<Listener<State>>();

  constructor(initial: State) {
    this.current = initial;
    this.told = initial;
  }

  get state(): State {
    return this.current;
  }

  /** Replaces the parts that are given. */
  set(parts: Partial<State>): void {
    this.current = { ...this.current, ...parts };
    if (this.isTelling) return;
    this.isTelling = true;
    queueMicrotask(() => this.tell());
  }

  /** Tells of each later change; returns what ends it. */
  subscribe(listener: Listener<State>): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  private tell(): void {
    this.isTelling = false;
    const before = this.told;
    const now = this.current;
    this.told = now;
    if (before === now) return;
    for (const listener of this.listeners) listener(now, before);
  }
}

/** Numbers asks, so that an answer that comes after a later ask is known and dropped. */
export class Latest {
  private number = 0;

  /** A function that is true while no later ask has begun. */
  begin(): () => boolean {
    this.number += 1;
    const mine = this.number;
    return () => mine === this.number;
  }

  /** Whatever is under way is no longer wanted. */
  drop(): void {
    this.number += 1;
  }
}
