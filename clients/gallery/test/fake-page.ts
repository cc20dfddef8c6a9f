// A page for tests without a browser: script elements that run files given as data, and a storage.

/** Arguments of a file's call. */
export interface Script {
  readonly kind: string;
  readonly text: string;
  /** Set if the file's call contains another path than its own. */
  readonly path?: string;
}

class FakeScript extends EventTarget {
  src = "";
  constructor(private readonly removed: () => void) {
    super();
  }
  remove(): void {
    this.removed();
  }
}

/** "silent": a script that calls nothing; "hangs": a script that never loads. */
export type Fault = Script | "silent" | "hangs" | null;

export class FakeDocument {
  /** Addresses in the order of requests. */
  readonly asked: string[] = [];
  /** Number of script elements in the page. */
  present = 0;
  readonly head = { append: (script: FakeScript): void => this.run(script) };
  private readonly faults = new Map<string, Fault>();

  constructor(readonly files: ReadonlyMap<string, Script>) {}

  createElement(): FakeScript {
    return new FakeScript(() => --this.present);
  }

  asDocument(): Document {
    return this as unknown as Document;
  }

  set(path: string, file: Fault): void {
    this.faults.set(path, file);
  }

  private run(script: FakeScript): void {
    ++this.present;
    this.asked.push(script.src);
    const path = decodeURIComponent(script.src.replace(/^data\//, "").replace(/\.js$/, ""));
    setTimeout(() => {
      const fault = this.faults.get(path);
      const file = fault === undefined ? this.files.get(path) ?? null : fault;
      if (file === "hangs") return;
      if (file !== null && file !== "silent")
        globalThis.sleightSaved?.(file.path ?? path, file.kind, file.text);
      script.dispatchEvent(new Event(file === null ? "error" : "load"));
    }, 1);
  }
}

export class FakeStorage implements Storage {
  isFull = false;
  private readonly items = new Map<string, string>();

  get length(): number { return this.items.size; }
  clear(): void { this.items.clear(); }
  getItem(key: string): string | null { return this.items.get(key) ?? null; }
  key(index: number): string | null { return [...this.items.keys()][index] ?? null; }
  removeItem(key: string): void { this.items.delete(key); }
  setItem(key: string, value: string): void {
    if (this.isFull) throw new Error("QuotaExceededError");
    this.items.set(key, value);
  }
}
