// The player's timeline: a lane for each animation with marks for its events, the time where two animations
// start to differ, the current time, and a time range for the builder. Kinds of marks differ in shape and in
// colour.
import type { MotionEvent } from "../motion/events";
import type { Parting, TimelineItem } from "../view/timeline";
import { el, setAttribute, setHidden, setText } from "./dom";
import { seconds } from "./words";

export interface TimelineData {
  readonly items: readonly TimelineItem[];
  readonly parts: readonly Parting[];
  readonly from: number;
  readonly to: number;
}

export interface TimelineOptions {
  readonly onSeek: (sharedS: number) => void;
  readonly onStep: (frames: number) => void;
  /** A person marked a range of shared time. */
  readonly onRange: (from: number, to: number) => void;
}

const laneHeight = 26;
const laneHeightMany = 16;
const inset = 8;
const hitPx = 5;

export class Timeline {
  readonly element: HTMLElement;
  private readonly canvas = el("canvas", { class: "timeline-canvas", "aria-hidden": "true" });
  private readonly head = el("div", { class: "timeline-head" });
  private readonly band = el("div", { class: "timeline-band", hidden: true });
  private readonly tip = el("div", { class: "timeline-tip", "aria-hidden": "true", hidden: true });
  private readonly slider: HTMLElement;
  private data: TimelineData = { items: [], parts: [], from: 0, to: 1 };
  private time = 0;
  private isMarking = false;
  private dragFrom: number | null = null;

  constructor(private readonly options: TimelineOptions) {
    this.slider = el(
      "div",
      {
        class: "timeline-track",
        role: "slider",
        tabindex: 0,
        id: "timeline",
        "aria-label": "Time",
      },
      this.canvas,
      this.band,
      this.head,
      this.tip,
    );
    this.element = el("div", { class: "timeline" }, this.slider);
    this.slider.addEventListener("pointerdown", (event) => this.down(event));
    this.slider.addEventListener("pointermove", (event) => this.move(event));
    this.slider.addEventListener("pointerup", () => this.up());
    this.slider.addEventListener("pointercancel", () => this.up());
    this.slider.addEventListener("pointerleave", () => setHidden(this.tip, true));
    this.slider.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => this.draw()).observe(this.slider);
  }

  show(data: TimelineData): void {
    this.data = data;
    const lane = data.items.length > 4 ? laneHeightMany : laneHeight;
    this.slider.style.height = `${Math.max(1, data.items.length) * lane + 6}px`;
    setAttribute(this.slider, "aria-valuemin", data.from.toFixed(3));
    setAttribute(this.slider, "aria-valuemax", data.to.toFixed(3));
    this.draw();
    this.setTime(this.time);
  }

  setTime(time: number): void {
    this.time = time;
    this.head.style.transform = `translateX(${this.placeOf(time)}px)`;
    setAttribute(this.slider, "aria-valuenow", time.toFixed(3));
    setAttribute(this.slider, "aria-valuetext", seconds(time));
  }

  /** While marking, dragging selects a time range instead of seeking. */
  setMarking(isMarking: boolean): void {
    this.isMarking = isMarking;
    this.slider.classList.toggle("is-marking", isMarking);
    if (!isMarking) setHidden(this.band, true);
  }

  draw(): void {
    const width = this.slider.clientWidth;
    const height = this.slider.clientHeight;
    if (width === 0 || height === 0) return;
    const ratio = Math.min(2, devicePixelRatio);
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    const context = this.canvas.getContext("2d");
    if (context === null) return;
    context.scale(ratio, ratio);
    const style = getComputedStyle(this.slider);
    const colour = (name: string): string => style.getPropertyValue(name).trim();
    const { items, parts } = this.data;
    const lane = (height - 6) / Math.max(1, items.length);
    items.forEach((item, i) => {
      const middle = 3 + lane * (i + 0.5);
      context.fillStyle = colour("--lane");
      context.fillRect(
        this.placeOf(item.startS),
        middle - 1.5,
        this.placeOf(item.endS) - this.placeOf(item.startS),
        3,
      );
      for (const event of item.events)
        mark(context, event.cause, this.placeOf(event.sharedS), middle, lane, colour);
    });
    context.strokeStyle = colour("--part");
    context.fillStyle = colour("--part");
    context.setLineDash([3, 3]);
    for (const { a, b, sharedS } of parts) {
      const x = this.placeOf(sharedS);
      const top = 3 + lane * (Math.min(a, b) + 0.2);
      const bottom = 3 + lane * (Math.max(a, b) + 0.8);
      context.beginPath();
      context.moveTo(x, top);
      context.lineTo(x, bottom);
      context.stroke();
      diamond(context, x, bottom, 4);
    }
  }

  private placeOf(time: number): number {
    const { from, to } = this.data;
    const width = this.slider.clientWidth - 2 * inset;
    const share = to > from ? (time - from) / (to - from) : 0;
    return inset + Math.min(1, Math.max(0, share)) * width;
  }

  private timeAt(event: PointerEvent): number {
    const { left } = this.slider.getBoundingClientRect();
    const { from, to } = this.data;
    const share = (event.clientX - left - inset) / Math.max(1, this.slider.clientWidth - 2 * inset);
    return from + Math.min(1, Math.max(0, share)) * (to - from);
  }

  private down(event: PointerEvent): void {
    this.slider.setPointerCapture(event.pointerId);
    this.dragFrom = this.timeAt(event);
    if (!this.isMarking) this.options.onSeek(this.dragFrom);
  }

  private move(event: PointerEvent): void {
    const time = this.timeAt(event);
    if (this.dragFrom === null) {
      this.showTip(event, time);
      return;
    }
    if (!this.isMarking) {
      this.options.onSeek(time);
      return;
    }
    const [from, to] = time < this.dragFrom ? [time, this.dragFrom] : [this.dragFrom, time];
    setHidden(this.band, false);
    this.band.style.left = `${this.placeOf(from)}px`;
    this.band.style.width = `${this.placeOf(to) - this.placeOf(from)}px`;
    this.options.onRange(from, to);
  }

  private up(): void {
    this.dragFrom = null;
  }

  private key(event: KeyboardEvent): void {
    const frames: Readonly<Record<string, number>> = {
      ArrowRight: 1,
      ArrowUp: 1,
      ArrowLeft: -1,
      ArrowDown: -1,
      PageUp: 15,
      PageDown: -15,
    };
    const step = frames[event.key];
    if (step !== undefined) this.options.onStep(step);
    else if (event.key === "Home") this.options.onSeek(this.data.from);
    else if (event.key === "End") this.options.onSeek(this.data.to);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  private showTip(event: PointerEvent, time: number): void {
    const box = this.slider.getBoundingClientRect();
    const lane = (box.height - 6) / Math.max(1, this.data.items.length);
    const index = Math.min(
      this.data.items.length - 1,
      Math.max(0, Math.floor((event.clientY - box.top - 3) / lane)),
    );
    const item = this.data.items[index];
    const x = this.placeOf(time);
    const near = item?.events.filter((other) => Math.abs(this.placeOf(other.sharedS) - x) <= hitPx) ?? [];
    const parted = this.data.parts.find(({ sharedS }) => Math.abs(this.placeOf(sharedS) - x) <= hitPx);
    const lines = near.slice(0, 4).map((other) => `${seconds(other.sharedS)}  ${other.words}`);
    if (near.length > 4) lines.push(`${near.length - 4} more events`);
    if (parted !== undefined) {
      const names = [parted.a, parted.b].map((i) => this.data.items[i]?.label ?? "");
      lines.push(`${seconds(parted.sharedS)}  ${names.join(" and ")} start to differ`);
    }
    setHidden(this.tip, lines.length === 0);
    setText(this.tip, lines.join("\n"));
    this.tip.style.left = `${Math.min(x, Math.max(0, box.width - 220))}px`;
  }
}

type ColourOf = (name: string) => string;

/** A hit is a bar, a change of motion a ring, an entry a triangle, and coming to rest a square. */
function mark(
  context: CanvasRenderingContext2D,
  cause: MotionEvent["cause"],
  x: number,
  y: number,
  lane: number,
  colour: ColourOf,
): void {
  const reach = Math.min(8, lane / 2 - 2);
  context.setLineDash([]);
  context.fillStyle = colour(`--event-${cause}`);
  context.strokeStyle = colour(`--event-${cause}`);
  context.lineWidth = 1.5;
  context.beginPath();
  if (cause === "hit") {
    context.moveTo(x, y - reach);
    context.lineTo(x, y + reach);
    context.stroke();
  } else if (cause === "mode") {
    context.arc(x, y, Math.min(3, reach), 0, 2 * Math.PI);
    context.stroke();
  } else if (cause === "start") {
    context.moveTo(x - 3, y - reach);
    context.lineTo(x + 5, y);
    context.lineTo(x - 3, y + reach);
    context.fill();
  } else context.fillRect(x - 3, y - 3, 6, 6);
}

function diamond(context: CanvasRenderingContext2D, x: number, y: number, reach: number): void {
  context.beginPath();
  context.moveTo(x, y - reach);
  context.lineTo(x + reach, y);
  context.lineTo(x, y + reach);
  context.lineTo(x - reach, y);
  context.fill();
}
