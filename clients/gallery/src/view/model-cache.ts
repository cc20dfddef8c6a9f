// A cache of one archive's animations for thumbnails. The cache loads animations in batches on request, and
// drops the least recently used animations above a limit.

import type { Animation, AnimationName } from "../data/types";
import { AnimationModel } from "./model";
import type { ArchiveStage } from "./stage";

/** source.animations() of the archive. After a rejection, callers may request the names again. */
export type Loader = (names: readonly AnimationName[], signal: AbortSignal) => Promise<readonly Animation[]>;

export interface CacheUser {
  /** Called when animations have arrived; with an empty list if requests failed or may be repeated. */
  came(animations: readonly Animation[]): void;
  /** Whether the model is in use, so that it must not be dropped. */
  isInUse(name: AnimationName): boolean;
}

/** Small batches, so that the first pictures appear soon. */
const BATCH = 8;
const BATCHES_AT_ONCE = 2;
const BYTES_MAX = 64 * 1024 * 1024;
/** Limit for GPU buffers, as each model has its own. */
const MODELS_MAX = 160;
const RETRY_MS_MIN = 500;
const RETRY_MS_MAX = 8000;

interface Held {
  readonly animation: Animation;
  model: AnimationModel | null;
}

export class ModelCache {
  /** From least to most recently used. */
  private readonly held = new Map<AnimationName, Held>();
  private bytes = 0;
  /** Names to request, the newest last. */
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

  /** Returns null and requests the animation if it isn't loaded. */
  get(name: AnimationName): AnimationModel | null {
    const held = this.held.get(name);
    if (held !== undefined) {
      this.held.delete(name);
      this.held.set(name, held);
      // Models are created only when drawn, so that a large answer doesn't delay a frame.
      held.model ??= new AnimationModel(this.stage, held.animation);
      return held.model;
    }
    if (this.asked.has(name) || this.failed.has(name)) return null;
    // The newest request has priority, because people look at it.
    this.wishes.delete(name);
    this.wishes.add(name);
    this.schedule(0);
    return null;
  }

  hasFailed(name: AnimationName): boolean { return this.failed.has(name); }
  /** Drops a request for a card that left the view before the request was sent. */
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

/** Estimated size: a segment has 20 numbers, and meshes are stored twice (merged and separate). */
function bytesOf(animation: Animation): number {
  let bytes = 180 * animation.recording.segments.count;
  for (const { places, normals, corners } of animation.meshes)
    bytes += 2 * (places.byteLength + normals.byteLength + corners.byteLength);
  return bytes;
}
