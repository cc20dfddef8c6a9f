// Animated thumbnails on small canvases that are added and removed.
//
// Only visible thumbnails are drawn, a few per frame in turn: few enough to keep frames short, and almost
// none while people scroll. With `still`, each thumbnail is one picture: the end of the animation, with trails.

import { PerspectiveCamera } from "three";
import type { Animation, AnimationName } from "../data/types";
import { aim, presetOf } from "./camera";
import { boxOfMotion } from "./framing";
import { firstContactS } from "../motion/events";
import type { AnimationModel } from "./model";
import { type Loader, ModelCache } from "./model-cache";
import { Screen, type SharedRenderer } from "./renderer";
import type { ArchiveStage } from "./stage";
import { THEMES, type ThemeName } from "./theme";

export interface ThumbnailsOptions {
  readonly load: Loader;
  readonly stage: ArchiveStage;
  readonly theme: ThemeName;
  readonly still: boolean;
}

/** State of a canvas's picture, in its attribute `data-thumbnail`. */
export type ThumbnailState = "waiting" | "drawn" | "failed";

interface Card {
  readonly canvas: HTMLCanvasElement;
  readonly screen: Screen;
  name: AnimationName;
  isInView: boolean;
  /** Time when the animation started to play. */
  since: number;
  /** Whether the picture must be drawn even if the animation doesn't move. */
  isStale: boolean;
}

/** Thumbnails this near to the view are drawn in advance. */
const MARGIN_PX = 150;
/** Pause at the end of each animation. */
const HOLD_S = 1.2;
/** Maximum drawing time per frame. */
const BUDGET_MS = 9;
const BUDGET_SCROLLING_MS = 4;
const SCROLLING_MS = 140;
/** Frames further apart than this are slow: then fewer pictures are drawn per frame. */
const SLOW_MS = 40;
const QUICK_MS = 24;
const AT_ONCE_MAX = 12;
const STILL_TRAIL_OPACITY = 0.5;

export class Thumbnails {
  private readonly cards = new Map<HTMLCanvasElement, Card>();
  /** A canvas keeps its screen, even if cards reuse the canvas. */
  private readonly screens = new WeakMap<HTMLCanvasElement, Screen>();
  private readonly inView = new Set<Card>();
  /** Visible cards, in the order of drawing. */
  private turn: Card[] = [];
  private readonly observer: IntersectionObserver;
  private readonly sizes: ResizeObserver;
  private readonly unlisten: () => void;
  private readonly ends = new AbortController();
  private readonly eye = new PerspectiveCamera();
  private readonly cache: ModelCache;
  private readonly stage: ArchiveStage;
  private theme: ThemeName;
  private still: boolean;
  private isPaused = false;
  private isOver = false;
  private frame = 0;
  private last = 0;
  private scrolledAt = -Infinity;
  private atOnce = 2;

  constructor(private readonly renderer: SharedRenderer, options: ThumbnailsOptions) {
    ({ stage: this.stage, theme: this.theme, still: this.still } = options);
    this.cache = new ModelCache(this.stage, options.load, {
      came: (models) => this.came(models),
      isInUse: (name) => this.isInUse(name),
    });
    const margin = { rootMargin: `${MARGIN_PX}px` };
    this.observer = new IntersectionObserver((changes) => this.seen(changes), margin);
    this.sizes = new ResizeObserver((changes) => {
      for (const { target } of changes) {
        const card = this.cards.get(target as HTMLCanvasElement);
        if (card !== undefined) card.isStale = true;
      }
      this.wake();
    });
    this.unlisten = renderer.onRestored(() => this.drawAgain());
    const scrolled = (): void => { this.scrolledAt = performance.now(); };
    document.addEventListener("scroll", scrolled, { capture: true, passive: true, signal: this.ends.signal });
  }

  /** Shows the animation on the canvas. CSS sets the canvas's size. */
  show(canvas: HTMLCanvasElement, name: AnimationName): void {
    const card = this.cards.get(canvas);
    if (card === undefined) {
      const screen = this.screens.get(canvas) ?? new Screen(canvas);
      this.screens.set(canvas, screen);
      this.cards.set(canvas, { canvas, screen, name, isInView: false, since: 0, isStale: true });
      this.observer.observe(canvas);
      this.sizes.observe(canvas);
    } else if (card.name === name) {
      return;
    } else {
      card.name = name;
      card.since = 0;
      card.isStale = true;
      this.wake();
    }
    canvas.dataset["thumbnail"] = "waiting" satisfies ThumbnailState;
  }

  hide(canvas: HTMLCanvasElement): void {
    const card = this.cards.get(canvas);
    if (card === undefined) return;
    this.observer.unobserve(canvas);
    this.sizes.unobserve(canvas);
    this.cards.delete(canvas);
    this.inView.delete(card);
    card.isInView = false;
    this.cache.forget(card.name);
  }

  setTheme(theme: ThemeName): void {
    this.theme = theme;
    this.drawAgain();
  }
  setStill(still: boolean): void {
    this.still = still;
    this.drawAgain();
  }
  /** Stops all motion, for instance while the player plays. Missing pictures are still drawn. */
  pause(isPaused: boolean): void {
    this.isPaused = isPaused;
    this.wake();
  }
  /** Draws all cards again; for canvases that changed their size. */
  drawAgain(): void {
    for (const card of this.cards.values()) card.isStale = true;
    this.wake();
  }

  dispose(): void {
    cancelAnimationFrame(this.frame);
    this.isOver = true;
    this.ends.abort();
    this.observer.disconnect();
    this.sizes.disconnect();
    this.unlisten();
    this.cache.dispose();
    this.cards.clear();
    this.inView.clear();
  }

  // ---- Private

  /** All pictures share one frame, which grows to contain new animations. Small pictures show the motion
   *  from the first contact on: with the flight before, the rest would be a few pixels. */
  private came(animations: readonly Animation[]): void {
    const { frame, scene } = this.stage;
    let hasGrown = false;
    for (const { recording } of animations)
      hasGrown = frame.include(boxOfMotion(recording, scene, firstContactS(recording))) || hasGrown;
    if (hasGrown) this.drawAgain();
    else this.wake();
  }

  private isInUse(name: AnimationName): boolean {
    for (const card of this.inView) if (card.name === name) return true;
    return false;
  }

  private seen(changes: readonly IntersectionObserverEntry[]): void {
    for (const change of changes) {
      const card = this.cards.get(change.target as HTMLCanvasElement);
      if (card === undefined) continue;
      card.isInView = change.isIntersecting;
      if (card.isInView) {
        this.inView.add(card);
      } else {
        this.inView.delete(card);
        this.cache.forget(card.name);
      }
    }
    this.wake();
  }

  private wake(): void {
    if (this.frame !== 0 || this.isOver || this.inView.size === 0) return;
    this.frame = requestAnimationFrame((now) => this.onFrame(now));
  }

  private onFrame(now: number): void {
    this.frame = 0;
    if (this.isOver) return;
    const isScrolling = now - this.scrolledAt < SCROLLING_MS;
    this.adapt(now, isScrolling);
    const until = performance.now() + (isScrolling ? BUDGET_SCROLLING_MS : BUDGET_MS);
    const most = isScrolling ? 1 : this.atOnce;
    let isWanted = false;
    let drawn = 0;
    if (this.turn.length === 0) this.turn = [...this.inView];
    // Cards without a picture come first.
    if (drawn < most) for (const card of this.inView) {
      if (!card.isStale) continue;
      isWanted ||= this.cache.get(card.name) !== null || isScrolling;
      if (drawn >= most || performance.now() >= until) break;
      if (this.draw(card, now)) ++drawn;
    }
    const moves = !this.still && !this.isPaused;
    while (moves && !isScrolling && drawn < most && this.turn.length > 0 && performance.now() < until) {
      const card = this.turn.shift()!;
      if (card.isInView && !card.isStale && this.draw(card, now)) ++drawn;
    }
    if (isWanted || isScrolling || (moves && this.inView.size > 0)) this.wake();
  }

  /** Adapts the number of pictures per frame to the frames' duration, because the GPU's work can't be
   *  measured otherwise. */
  private adapt(now: number, isScrolling: boolean): void {
    const gap = now - this.last;
    this.last = now;
    if (isScrolling || gap > 500) return;
    if (gap > SLOW_MS) this.atOnce = Math.max(1, Math.floor(this.atOnce / 2));
    else if (gap < QUICK_MS) this.atOnce = Math.min(this.atOnce + 0.25, AT_ONCE_MAX);
  }

  /** Returns false if there is nothing to draw yet. */
  private draw(card: Card, now: number): boolean {
    const { canvas, screen } = card;
    const model = this.cache.get(card.name);
    if (model === null) {
      if (this.cache.hasFailed(card.name)) canvas.dataset["thumbnail"] = "failed" satisfies ThumbnailState;
      return false;
    }
    const width = Math.round(canvas.clientWidth * this.renderer.pixelRatio);
    const height = Math.round(canvas.clientHeight * this.renderer.pixelRatio);
    const { background } = THEMES[this.theme];
    if (!this.renderer.begin(width, height, background)) return false;
    if (card.since === 0) card.since = now;
    this.pose(model, this.timeOf(card, model, now));
    const { box, frame, three } = this.stage;
    aim(this.eye, presetOf("home", box, model.isPlanar), frame.box, width / height);
    this.renderer.draw(three, this.eye, { x: 0, y: 0, width, height }, background);
    this.renderer.finish(screen);
    card.isStale = false;
    if (canvas.dataset["thumbnail"] !== "drawn") canvas.dataset["thumbnail"] = "drawn";
    return true;
  }

  private pose(model: AnimationModel, t: number): void {
    this.stage.setTheme(this.theme);
    this.stage.show(model, t);
    model.hideMarks();
    if (this.still) model.trails.show(t, STILL_TRAIL_OPACITY);
    else model.hideTrails();
  }

  private timeOf(card: Card, model: AnimationModel, now: number): number {
    const end = model.animation.recording.endS;
    if (this.still) return end;
    return Math.min(((now - card.since) / 1000) % (end + HOLD_S), end);
  }
}
