// window.sleightGallery: what browser tests read of the page, which shows itself on canvases.
//
// It is read-only: tests act through the page as people do. Two things alone do something: loseContext(),
// as a driver would, and showOnly(), so that each body can be told from what is before and behind it.

import type { Player } from "./player";
import type { OnScreen } from "./picking";
import type { SharedRenderer } from "./renderer";

export interface TestHook {
  /** null: no player is open. */
  readonly player: PlayerView | null;
  readonly renderer: { readonly available: boolean; readonly isLost: boolean; readonly isSoftware: boolean };
  /** Loses the GPU's context for so long. */
  loseContext(forMs: number): void;
}

export interface PlayerView {
  readonly labels: readonly string[];
  readonly time: number;
  readonly range: { readonly from: number; readonly to: number };
  readonly isPlaying: boolean;
  /** All that was asked for is drawn. */
  readonly isSettled: boolean;
  /** Pictures drawn so far. */
  readonly frames: number;
  readonly cells: readonly { x: number; y: number; width: number; height: number }[];
  /** An animation's own time at the shared one that is shown. */
  ownTime(index: number): number;
  /** Where a body's centre is at a time of its animation's own: CSS pixels from the canvas' upper left. */
  screenOf(index: number, body: number, t: number): OnScreen;
  /** Likewise of any place of the scene's frame (z up, metres). */
  screenOfPlace(index: number, place: readonly [number, number, number], radiusM: number): OnScreen;
  /** Draws that body alone; -1: nothing at all; null: everything again. */
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
