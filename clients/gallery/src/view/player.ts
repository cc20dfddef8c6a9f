// Shows up to nine animations side by side in one canvas, aligned in time and seen by one orbiting camera.
// Draws only after changes.
//
// Buttons, keys and timeline are in src/ui: they call the methods and listen to onEvent. Times are shared
// times (motion/sync.ts) in seconds. Pixels are CSS pixels from the canvas's upper left.

import type { Animation, Place } from "../data/types";
import { nextTime, previousTime } from "../motion/events";
import { Pose } from "../motion/pose";
import { type Range, sharedRange, shiftOf, type SyncMode } from "../motion/sync";
import type { Box } from "./box";
import { BoxDrawer } from "./box-drawer";
import type { CameraState, Preset } from "./camera";
import { type Cell, CELLS_MAX } from "./cells";
import { Clock } from "./clock";
import { AnimationModel } from "./model";
import type { OnScreen } from "./picking";
import { Pointer } from "./pointer";
import { Screen, type SharedRenderer } from "./renderer";
import type { ArchiveStage } from "./stage";
import { THEMES, type ThemeName } from "./theme";
import { type Timeline, timelineOf, toleranceOf } from "./timeline";
import { Views } from "./views";

export interface PlayerItem {
  readonly stage: ArchiveStage;
  readonly animation: Animation;
  readonly label: string;
}

export interface Picked {
  /** Index of the animation. */
  readonly index: number;
  /** The feature under the pointer; bodies come first. */
  readonly feature: number;
  readonly name: string;
}

export type PlayerEvent =
  | { readonly kind: "time"; readonly time: number }
  | { readonly kind: "playing"; readonly isPlaying: boolean }
  | { readonly kind: "camera"; readonly camera: CameraState }
  /** null: the click hit nothing. */
  | { readonly kind: "pick"; readonly picked: Picked | null }
  | { readonly kind: "box"; readonly box: Box | null }
  /** Cells have moved, so labels over them must move too. */
  | { readonly kind: "layout" };

const FRAME_S = 1 / 60;
const TURN_RAD_PER_PX = 0.008;

const pose = new Pose();

export class Player {
  onEvent: (event: PlayerEvent) => void = () => undefined;
  private items: readonly PlayerItem[] = [];
  private shifts: readonly number[] = [];
  private eventTimes = new Float64Array(0);
  private mode: SyncMode = "start";
  private readonly clock = new Clock();
  private readonly views = new Views();
  private ghostOf: number | null = null;
  private hasTrails = false;
  private hasMarks = true;
  private only: number | null = null;
  private width = 0;
  private height = 0;
  private frame = 0;
  private isDirty = false;
  private last = 0;
  private drawn = 0;
  private readonly drawer = new BoxDrawer();
  private readonly screen: Screen;
  /** The cell in which a drag of the box started. */
  private dragCell = -1;

  constructor(
    private readonly canvas: HTMLCanvasElement, private readonly renderer: SharedRenderer,
    private theme: ThemeName,
  ) {
    this.drawer.setTheme(theme);
    this.screen = new Screen(canvas);
    new ResizeObserver(() => this.measure()).observe(canvas);
    new Pointer(canvas, {
      grab: (x, y) => this.grabBox(x, y),
      grabbed: (x, y) => this.pullBox(x, y),
      released: () => this.releaseBox(),
      turn: (dx, dy) => this.orbit(-TURN_RAD_PER_PX * dx, TURN_RAD_PER_PX * dy),
      move: (dx, dy) => this.pan(dx, dy),
      zoom: (factor) => this.zoom(factor),
      click: (x, y) => this.onEvent({ kind: "pick", picked: this.pick(x, y) }),
      hover: (x, y) => this.hover(x, y),
    });
    renderer.onRestored(() => this.redraw());
    this.measure();
  }

  // ---- Contents

  /** At most nine animations. Camera and time stay if they are still valid. */
  setAnimations(items: readonly PlayerItem[]): void {
    const before = new Map(this.models.map((model) => [model.animation, model]));
    this.items = items.slice(0, CELLS_MAX);
    const models = this.items.map(({ stage, animation }) => {
      const found = before.get(animation);
      if (found === undefined || found.stage !== stage) return new AnimationModel(stage, animation);
      before.delete(animation);
      return found;
    });
    for (const model of before.values()) model.dispose();
    this.views.setModels(models);
    if (this.ghostOf !== null && this.ghostOf >= this.models.length) this.ghostOf = null;
    this.synchronise();
    this.layOut();
  }

  /** Draws this animation's bodies transparently in all other animations; null: none. */
  setGhost(of: number | null): void {
    this.ghostOf = of !== null && of >= 0 && of < this.models.length ? of : null;
    this.redraw();
  }
  get ghost(): number | null { return this.ghostOf; }

  setTrails(on: boolean): void { this.hasTrails = on; this.redraw(); }
  setMarks(on: boolean): void { this.hasMarks = on; this.redraw(); }
  /** For tests: draws only this body in all animations; -1 draws no body; null draws all again. */
  setOnly(body: number | null): void { this.only = body; this.redraw(); }
  setTheme(theme: ThemeName): void {
    this.theme = theme;
    this.drawer.setTheme(theme);
    this.redraw();
  }

  // ---- Time

  get time(): number { return this.clock.time; }
  get range(): Range { return this.clock.range; }
  get isPlaying(): boolean { return this.clock.isPlaying; }

  play(): void {
    if (this.models.length === 0 || this.clock.isPlaying) return;
    this.clock.play();
    this.last = 0;
    this.onEvent({ kind: "playing", isPlaying: true });
    this.redraw();
  }
  pause(): void {
    if (!this.clock.isPlaying) return;
    this.clock.isPlaying = false;
    this.onEvent({ kind: "playing", isPlaying: false });
    this.redraw();
  }
  toggle(): void { if (this.clock.isPlaying) this.pause(); else this.play(); }
  setSpeed(speed: number): void { this.clock.setSpeed(speed); }
  setLoop(on: boolean): void { this.clock.isLooping = on; }
  seek(t: number): void { this.clock.seek(t); this.redraw(); }
  /** Steps by frames of 1/60 s, and pauses. */
  step(frames: number): void { this.pause(); this.seek(this.clock.time + frames * FRAME_S); }
  /** Moves to the nearest event of any animation after (1) or before (-1) the present time, and pauses. */
  toEvent(direction: 1 | -1): void {
    this.pause();
    const find = direction > 0 ? nextTime : previousTime;
    const to = find(this.eventTimes, this.clock.time);
    if (to !== null) this.seek(to);
  }
  setSync(mode: SyncMode): void {
    this.mode = mode;
    this.synchronise();
  }

  // ---- For the timeline

  timeline(): Timeline {
    return timelineOf(this.items, this.models, this.shifts, toleranceOf(this.models));
  }

  // ---- Camera

  get camera(): CameraState { return this.views.camera; }
  setCamera(camera: CameraState): void {
    this.views.setCamera(camera);
    this.onEvent({ kind: "camera", camera: this.views.camera });
    this.redraw();
  }
  preset(preset: Preset): void { this.setCamera(this.views.preset(preset)); }
  orbit(azimuth: number, elevation: number): void {
    const { camera } = this.views;
    this.setCamera({
      ...camera, azimuth: camera.azimuth + azimuth, elevation: camera.elevation + elevation,
    });
  }
  zoom(factor: number): void {
    const { camera } = this.views;
    this.setCamera({ ...camera, zoom: camera.zoom * factor });
  }
  /** Pans by pixels to the right and down, as if a person pulled the scene. */
  pan(dx: number, dy: number): void { this.setCamera(this.views.pulled(dx, dy)); }

  // ---- The box

  get box(): Box | null { return this.drawer.box; }
  /** The next drag on the canvas draws a new box. */
  startBox(): void { this.drawer.isArmed = true; this.canvas.style.cursor = "crosshair"; }
  setBox(box: Box | null): void { this.drawer.set(box); this.redraw(); }
  /** Removes the box. */
  endBox(): void {
    this.drawer.isArmed = false;
    this.canvas.style.cursor = "";
    this.setBox(null);
  }

  // ---- Places on the screen

  cells(): readonly Cell[] { return this.views.cells; }

  pick(x: number, y: number): Picked | null {
    const point = this.views.pointAt(x, y);
    if (point === null) return null;
    const { index } = point;
    const feature = this.views.featureAt(point, this.ownTime(index));
    const name = this.models[index]?.stage.scene.features[feature]?.name;
    return name === undefined ? null : { index, feature, name };
  }

  /** The screen position of a body at its animation's own time. */
  screenOf(index: number, body: number, t: number): OnScreen {
    const model = this.models[index];
    if (model === undefined || !model.animation.recording.centreAt(body, t, pose))
      return { x: 0, y: 0, radiusPx: 0, visible: false };
    const radius = model.stage.scene.features[body]?.radius_m ?? 0;
    return this.views.screenOf(index, [pose.x, pose.y, pose.z], radius);
  }

  /** The screen position of a place in the scene's frame, and the size of a ball around it. */
  screenOfPlace(index: number, place: Place, radiusM: number): OnScreen {
    return this.views.screenOf(index, place, radiusM);
  }

  /** The animation's own time at the present shared time. */
  ownTime(index: number): number { return this.clock.time + (this.shifts[index] ?? 0); }
  get count(): number { return this.models.length; }
  labelOf(index: number): string { return this.items[index]?.label ?? ""; }
  /** Number of pictures drawn so far; for tests. */
  get frames(): number { return this.drawn; }
  /** Whether nothing waits to be drawn. */
  get isSettled(): boolean { return !this.isDirty && !this.clock.isPlaying; }

  redraw(): void {
    this.isDirty = true;
    if (this.frame === 0) this.frame = requestAnimationFrame((now) => this.onFrame(now));
  }

  // ---- Private

  private get models(): readonly AnimationModel[] { return this.views.models; }

  private onFrame(now: number): void {
    this.frame = 0;
    const wasPlaying = this.clock.isPlaying;
    if (wasPlaying) {
      const ended = this.clock.advance(this.last === 0 ? 0 : (now - this.last) / 1000);
      this.last = now;
      if (ended) this.onEvent({ kind: "playing", isPlaying: false });
    }
    this.isDirty = false;
    this.draw();
    this.onEvent({ kind: "time", time: this.clock.time });
    if (this.clock.isPlaying) this.redraw();
  }

  private draw(): void {
    const theme = THEMES[this.theme];
    const ratio = this.renderer.pixelRatio;
    const width = Math.round(this.width * ratio);
    const height = Math.round(this.height * ratio);
    if (!this.renderer.begin(width, height, theme.divider)) return;
    this.drawer.setRatio(ratio);
    const ghost = this.ghostOf === null ? undefined : this.models[this.ghostOf];
    for (let i = 0; i < this.models.length; ++i) {
      const model = this.models[i]!;
      const cell = this.views.cells[i];
      if (cell === undefined) continue;
      const t = this.ownTime(i);
      const { stage } = model;
      const ghostAt = ghost === undefined || i === this.ghostOf
        ? null : { recording: ghost.animation.recording, t: this.ownTime(this.ghostOf ?? 0) };
      stage.setTheme(this.theme);
      stage.show(model, t, ghostAt, this.only);
      if (this.hasTrails && this.only === null) model.trails.show(t, theme.trailOpacity);
      else model.hideTrails();
      if (this.hasMarks && this.only === null) model.marks.show(t, theme.mark, ratio);
      else model.hideMarks();
      stage.three.add(this.drawer.group);
      this.views.aimAt(i);
      this.renderer.draw(stage.three, this.views.eye, scaled(cell, ratio), theme.background);
      this.drawer.group.removeFromParent();
    }
    this.renderer.finish(this.screen);
    ++this.drawn;
  }

  private synchronise(): void {
    const recordings = this.models.map((model) => model.animation.recording);
    this.shifts = recordings.map((recording) => shiftOf(recording, this.mode));
    this.clock.setRange(sharedRange(recordings, this.mode));
    const times = this.models.flatMap((model, i) =>
      model.events.map((event) => event.timeS - this.shifts[i]!));
    this.eventTimes = Float64Array.from(times).sort();
    this.redraw();
  }

  private measure(): void {
    this.width = this.canvas.clientWidth;
    this.height = this.canvas.clientHeight;
    this.layOut();
  }

  private layOut(): void {
    this.views.layOut(this.width, this.height);
    this.onEvent({ kind: "layout" });
    this.redraw();
  }

  // ---- Drags of the box

  private grabBox(x: number, y: number): boolean {
    const point = this.views.pointAt(x, y);
    if (point === null) return false;
    const view = this.models[point.index]!.stage.box;
    if (!this.drawer.grab(point, this.views.eye, view, this.camera.elevation)) return false;
    this.dragCell = point.index;
    return true;
  }

  private pullBox(x: number, y: number): void {
    const point = this.views.pointAt(x, y, this.dragCell);
    const model = this.models[this.dragCell];
    if (point === null || model === undefined || !this.drawer.grabbed(point.ray, model.stage.box)) return;
    this.onEvent({ kind: "box", box: this.drawer.box });
    this.redraw();
  }

  private releaseBox(): void {
    this.drawer.released();
    this.canvas.style.cursor = this.drawer.isArmed ? "crosshair" : "";
    this.onEvent({ kind: "box", box: this.drawer.box });
    this.redraw();
  }

  private hover(x: number, y: number): void {
    if (this.drawer.box === null || this.drawer.isArmed) return;
    const point = this.views.pointAt(x, y);
    const face = point === null ? null : this.drawer.handleAt(point, this.views.eye);
    this.canvas.style.cursor = face === null ? "" : "move";
  }
}

function scaled(cell: Cell, ratio: number): Cell {
  if (ratio === 1) return cell;
  const x = Math.round(cell.x * ratio);
  const y = Math.round(cell.y * ratio);
  return {
    x, y, width: Math.round((cell.x + cell.width) * ratio) - x,
    height: Math.round((cell.y + cell.height) * ratio) - y,
  };
}
