// The player's time: position, speed, and what happens at the end. Pure: the caller passes the elapsed time.

import type { Range } from "../motion/sync";

export const SPEED_MIN = 1 / 16;
export const SPEED_MAX = 4;
/** Longer pauses between frames (such as a hidden tab) count as this. */
const GAP_S_MAX = 0.1;
/** Pause at the end before a loop repeats. */
const HOLD_S = 0.8;

export class Clock {
  time = 0;
  range: Range = { from: 0, to: 0 };
  speed = 1;
  isPlaying = false;
  isLooping = true;
  private heldS = 0;

  seek(t: number): void {
    this.time = Math.min(Math.max(t, this.range.from), this.range.to);
    this.heldS = 0;
  }

  /** Keeps the time if it is within the new range. */
  setRange(range: Range): void {
    this.range = range;
    this.seek(this.time);
  }

  setSpeed(speed: number): void {
    if (Number.isFinite(speed)) this.speed = Math.min(Math.max(speed, SPEED_MIN), SPEED_MAX);
  }

  /** At the end, play() restarts from the beginning. */
  play(): void {
    if (this.time >= this.range.to) this.seek(this.range.from);
    this.isPlaying = true;
  }

  /** Advances by elapsed real time. Returns true if it reached the end and stopped. */
  advance(elapsedS: number): boolean {
    if (!this.isPlaying) return false;
    const gap = Math.min(Math.max(elapsedS, 0), GAP_S_MAX);
    if (this.time < this.range.to) {
      this.time = Math.min(this.time + gap * this.speed, this.range.to);
      this.heldS = 0;
      if (this.time < this.range.to || this.isLooping) return false;
      this.isPlaying = false;
      return true;
    }
    this.heldS += gap;
    if (this.heldS >= HOLD_S) this.seek(this.range.from);
    return false;
  }
}
