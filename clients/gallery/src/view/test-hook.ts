// window.sleightGallery: the state of the page's canvases, for browser tests.
//
// The hook is read-only, because tests use the page as people do. Two functions are exceptions: loseContext()
// loses the GPU's context as a driver would, and showOnly() draws one body without the others.

import type { Player } from "./player";
import type { OnScreen } from "./picking";
import type { SharedRenderer } from "./renderer";

export interface TestHook {
  /** null: the player is closed. */
  readonly player: PlayerView | null;
  readonly renderer: { readonly available: boolean; readonly isLost: boolean; readonly isSoftware: boolean };
  /** Loses the GPU's context for this time. */
  loseContext(forMs: number): void;
}

export interface PlayerView {
  readonly labels: readonly string[];
  readonly time: number;
  readonly range: { readonly from: number; readonly to: number };
  readonly isPlaying: boolean;
  /** Whether nothing waits to be drawn. */
  readonly isSettled: boolean;
  /** Number of pictures drawn so far. */
  readonly frames: number;
  readonly cells: readonly { x: number; y: number; width: number; height: number }[];
  /** The animation's own time at the present shared time. */
  ownTime(index: number): number;
  /** Position of a body's centre at its animation's own time, in CSS pixels from the canvas's upper left. */
  screenOf(index: number, body: number, t: number): OnScreen;
  /** Position of a place in the scene's frame (z up, metres), in the same pixels. */
  screenOfPlace(index: number, place: readonly [number, number, number], radiusM: number): OnScreen;
  /** Draws only this body; -1: nothing; null: everything again. */
  showOnly(body: number | null): void;
}

declare global {
  interface Window {
    sleightGallery?: TestHook;
  }
}

export function installTestHook(renderer: SharedRenderer, player: () => Player | null): void {
  window.sleightGallery = {
    get player() {
      const shown = player();
      return shown === null ? null : viewOf(shown);
    },
    renderer: {
      get available() { return renderer.available; },
      get isLost() { return renderer.isLost; },
      get isSoftware() { return renderer.isSoftware; },
    },
    loseContext: (forMs) => {
      const back = renderer.loseContext();
      setTimeout(back, forMs);
    },
  };
}

function viewOf(player: Player): PlayerView {
  return {
    labels: Array.from({ length: player.count }, (_, index) => player.labelOf(index)),
    time: player.time,
    range: player.range,
    isPlaying: player.isPlaying,
    isSettled: player.isSettled,
    frames: player.frames,
    cells: player.cells(),
    ownTime: (index) => player.ownTime(index),
    screenOf: (index, body, t) => player.screenOf(index, body, t),
    screenOfPlace: (index, place, radiusM) => player.screenOfPlace(index, place, radiusM),
    showOnly: (body) => player.setOnly(body),
  };
}
