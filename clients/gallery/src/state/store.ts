// A store of one immutable state, replaced as a whole. Listeners compare the parts that they show with the
// previous state. Changes within one turn of the event loop cause one notification, so that five changes in a
// row draw the page once.

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

  /** Replaces the given parts. */
  set(parts: Partial<State>): void {
    this.current = { ...this.current, ...parts };
    if (this.isTelling) return;
    this.isTelling = true;
    queueMicrotask(() => this.tell());
  }

  /** Calls the listener at each later change; returns a function that removes it. */
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

/** Numbers requests, so that answers to earlier requests can be dropped. */
export class Latest {
  private number = 0;

  /** Returns a function that is true until a later request begins. */
  begin(): () => boolean {
    this.number += 1;
    const mine = this.number;
    return () => mine === this.number;
  }

  /** Makes the answers of all requests so far unwanted. */
  drop(): void {
    this.number += 1;
  }
}
