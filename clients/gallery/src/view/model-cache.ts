// Animations of one archive that thumbnails show: loaded in batches as they are wanted, and bounded,
// the ones that were wanted longest ago going first.

import type { Animation, AnimationName } from "../data/types";
import { AnimationModel } from "./model";
import type { ArchiveStage } from "./stage";

/** As source.animations() of the archive; rejected: those that asked may ask again. */
export type Loader = (names: readonly AnimationName[], signal: AbortSignal) => Promise<readonly Animation[]>;

export interface CacheUser {
  /** These have come; none of them: something has failed, or may be asked for again. */
  came(animations: readonly Animation[]): void;
  /** Whether a model may not be dropped. */
  isInUse(name: AnimationName): boolean;
}

/** A batch is small, so that the first pictures come soon. */
const BATCH = 8;
const BATCHES_AT_ONCE = 2;
const BYTES_MAX = 64 * 1024 * 1024;
/** Each has buffers of its own on the GPU. */
const MODELS_MAX = 160;
const RETRY_MS_MIN = 500;
const RETRY_MS_MAX = 8000;

interface Held {
  readonly animation: Animation;
  model: AnimationModel | null;
}

export class ModelCache {
  /** In the order of last use, the longest ago first. */
  private readonly held = new Map<AnimationName, Held>();
  private bytes = 0;
  /** Wanted and not asked for; the newest wish last. */
  private readonly wishes = new Set<AnimationName>();
  private readonly asked = new Set<AnimationName>();
  private readonly failed = new Set<AnimationName>();
  private inFlight = 0;
  private timer: ReturnType<typeof setTimeout> | null = null;
  private retryMs = RETRY_MS_MIN;
  private readonly ends = new AbortController();

  constructor(
    private readonly stage: ArchiveStage, private readonly load: Loader, private readonly user: CacheUser,
  ) {}

  /** null: not there yet; it is asked for. */
  get(name: AnimationName): AnimationModel | null {
    const held = this.held.get(name);
    if (held !== undefined) {
      this.held.delete(name);
      this.held.set(name, held);
      // Not before it is drawn, so that an answer of many holds up no frame.
      held.model ??= new AnimationModel(this.stage, held.animation);
      return held.model;
    }
    if (this.asked.has(name) || this.failed.has(name)) return null;
    // The newest wish comes first: it is what people look at.
    this.wishes.delete(name);
    this.wishes.add(name);
    this.schedule(0);
    return null;
  }

  hasFailed(name: AnimationName): boolean { return this.failed.has(name); }
  /** No longer in view before it was asked for. */
  forget(name: AnimationName): void { this.wishes.delete(name); }

  dispose(): void {
    this.ends.abort();
    if (this.timer !== null) clearTimeout(this.timer);
    for (const { model } of this.held.values()) model?.dispose();
    this.held.clear();
    this.wishes.clear();
  }

  private schedule(afterMs: number): void {
    if (this.timer !== null || this.ends.signal.aborted) return;
    this.timer = setTimeout(() => {
      this.timer = null;
      while (this.inFlight < BATCHES_AT_ONCE && this.wishes.size > 0) void this.ask();
    }, afterMs);
  }

  private async ask(): Promise<void> {
    const names = [...this.wishes].slice(-BATCH);
    for (const name of names) {
      this.wishes.delete(name);
      this.asked.add(name);
    }
    ++this.inFlight;
    let animations: readonly Animation[] = [];
    try {
      animations = await this.load(names, this.ends.signal);
      if (this.ends.signal.aborted) return;
      this.retryMs = RETRY_MS_MIN;
      for (const animation of animations) this.keep(animation);
      for (const name of names) if (!this.held.has(name)) this.failed.add(name);
      this.trim();
    } catch {
      if (this.ends.signal.aborted) return;
      for (const name of names) this.failed.add(name);
      setTimeout(() => this.retry(names), this.retryMs);
      this.retryMs = Math.min(2 * this.retryMs, RETRY_MS_MAX);
    } finally {
      for (const name of names) this.asked.delete(name);
      --this.inFlight;
    }
    this.user.came(animations);
    if (this.wishes.size > 0) this.schedule(0);
  }

  private retry(names: readonly AnimationName[]): void {
    for (const name of names) this.failed.delete(name);
    if (!this.ends.signal.aborted) this.user.came([]);
  }

  private keep(animation: Animation): void {
    this.held.set(animation.name, { animation, model: null });
    this.bytes += bytesOf(animation);
  }

  private trim(): void {
    for (const [name, { animation, model }] of this.held) {
      if (this.bytes <= BYTES_MAX && this.held.size <= MODELS_MAX) return;
      if (this.user.isInUse(name)) continue;
      this.held.delete(name);
      this.bytes -= bytesOf(animation);
      model?.dispose();
    }
  }
}

/** About: a segment has 20 numbers; meshes are held twice, merged and not. */
function bytesOf(animation: Animation): number {
  let bytes = 180 * animation.recording.segments.count;
  for (const { places, normals, corners } of animation.meshes)
    bytes += 2 * (places.byteLength + normals.byteLength + corners.byteLength);
  return bytes;
}
