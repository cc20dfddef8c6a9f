// Converts mouse, pen and touch input on the player's canvas to rotation, panning, zoom and clicks. One
// finger or the left button rotates. Two fingers, the right button or Shift pan and zoom. The wheel zooms.

export interface PointerTarget {
  /** Returns true to receive the rest of this drag (for a handle or a new box). */
  grab(x: number, y: number): boolean;
  grabbed(x: number, y: number): void;
  released(): void;
  /** In CSS pixels. */
  turn(dx: number, dy: number): void;
  move(dx: number, dy: number): void;
  zoom(factor: number): void;
  click(x: number, y: number): void;
  hover(x: number, y: number): void;
}

/** A press that moves less than this is a click. */
const CLICK_PX = 4;
const WHEEL_ZOOM = 0.0015;

interface Finger {
  x: number;
  y: number;
}

export class Pointer {
  private readonly fingers = new Map<number, Finger>();
  private travelled = 0;
  private isGrabbed = false;

  constructor(private readonly canvas: HTMLCanvasElement, private readonly target: PointerTarget) {
    // Fingers on the canvas rotate the scene instead of scrolling the page.
    canvas.style.touchAction = "none";
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.moved(event));
    canvas.addEventListener("pointerup", (event) => this.up(event, true));
    canvas.addEventListener("pointercancel", (event) => this.up(event, false));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
  }

  private down(event: PointerEvent): void {
    if (event.button > 2) return;
    this.canvas.setPointerCapture(event.pointerId);
    const at = this.placeOf(event);
    this.fingers.set(event.pointerId, at);
    if (this.fingers.size > 1) return;
    this.travelled = 0;
    this.isGrabbed = event.button === 0 && this.target.grab(at.x, at.y);
  }

  private moved(event: PointerEvent): void {
    const at = this.placeOf(event);
    const finger = this.fingers.get(event.pointerId);
    if (finger === undefined) {
      this.target.hover(at.x, at.y);
      return;
    }
    const dx = at.x - finger.x;
    const dy = at.y - finger.y;
    const spreadBefore = this.spread();
    finger.x = at.x;
    finger.y = at.y;
    this.travelled += Math.hypot(dx, dy);
    if (this.isGrabbed) {
      this.target.grabbed(at.x, at.y);
    } else if (this.fingers.size > 1) {
      this.target.move(dx / this.fingers.size, dy / this.fingers.size);
      if (spreadBefore > 0) this.target.zoom(this.spread() / spreadBefore);
    } else if (this.travelled >= CLICK_PX) {
      if ((event.buttons & 6) !== 0 || event.shiftKey) this.target.move(dx, dy);
      else this.target.turn(dx, dy);
    }
  }

  private up(event: PointerEvent, isDone: boolean): void {
    const finger = this.fingers.get(event.pointerId);
    if (finger === undefined) return;
    this.fingers.delete(event.pointerId);
    if (this.fingers.size > 0) return;
    if (this.isGrabbed) this.target.released();
    else if (isDone && this.travelled < CLICK_PX) this.target.click(finger.x, finger.y);
    this.isGrabbed = false;
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
    this.target.zoom(Math.exp(-WHEEL_ZOOM * lines * event.deltaY));
  }

  /** Distance between two fingers. */
  private spread(): number {
    const [a, b] = this.fingers.values();
    return a !== undefined && b !== undefined ? Math.hypot(a.x - b.x, a.y - b.y) : 0;
  }

  private placeOf(event: PointerEvent): Finger {
    const bounds = this.canvas.getBoundingClientRect();
    return { x: event.clientX - bounds.left, y: event.clientY - bounds.top };
  }
}
