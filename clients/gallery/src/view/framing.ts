// Finds the interesting part of a scene: where bodies move and what they meet, within the archive's view. The
// archive's view is large enough for all possible throws.

import type { Looks, Mesh, Place, Scene } from "../data/types";
import type { Recording } from "../motion/recording";
import type { ViewBox } from "./camera";

type Corner = [number, number, number];

const NOTHING: ViewBox = {
  low: [Infinity, Infinity, Infinity], high: [-Infinity, -Infinity, -Infinity],
};
const AXES = [0, 1, 2] as const;
/** A shared frame grows by this additional share, so that it grows rarely. */
const GROW = 0.04;

export function union(a: ViewBox, b: ViewBox): ViewBox {
  return {
    low: [Math.min(a.low[0], b.low[0]), Math.min(a.low[1], b.low[1]), Math.min(a.low[2], b.low[2])],
    high: [Math.max(a.high[0], b.high[0]), Math.max(a.high[1], b.high[1]), Math.max(a.high[2], b.high[2])],
  };
}

export function isEmpty(box: ViewBox): boolean {
  return AXES.some((k) => !(box.low[k] < box.high[k]));
}

function holds(outer: ViewBox, inner: ViewBox): boolean {
  return AXES.every((k) => inner.low[k] >= outer.low[k] && inner.high[k] <= outer.high[k]);
}

/** The intersection; `a` itself if the boxes don't overlap. */
function within(a: ViewBox, bounds: ViewBox): ViewBox {
  const low: Corner = [0, 0, 0];
  const high: Corner = [0, 0, 0];
  for (const k of AXES) {
    low[k] = Math.max(a.low[k], bounds.low[k]);
    high[k] = Math.min(a.high[k], bounds.high[k]);
  }
  return { low, high };
}

/** The box of goals and of features within the view: what bodies are thrown at. */
export function boxOfLooks(scene: Scene, meshes: readonly Mesh[]): ViewBox {
  const view: ViewBox = { low: scene.view_low_m, high: scene.view_high_m };
  let box = NOTHING;
  for (const mesh of meshes) {
    if (scene.features[mesh.feature]?.kind === "body") continue;
    const of = boxOfPlaces(mesh.places);
    const isLarge = ([0, 1] as const).some((k) => of.high[k] - of.low[k] > view.high[k] - view.low[k]);
    if (!isLarge) box = union(box, within(of, view));
  }
  return box;
}

function boxOfPlaces(places: Float32Array): ViewBox {
  const low: Corner = [Infinity, Infinity, Infinity];
  const high: Corner = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < places.length; i += 3) {
    // Meshes have y up.
    const at: Place = [places[i]!, -places[i + 2]!, places[i + 1]!];
    for (const k of AXES) {
      low[k] = Math.min(low[k], at[k]);
      high[k] = Math.max(high[k], at[k]);
    }
  }
  return { low, high };
}

/** The box of the bodies' motion from a time on, including their sizes. */
export function boxOfMotion(recording: Recording, scene: Scene, fromS = -Infinity): ViewBox {
  const { segments } = recording;
  const low: Corner = [Infinity, Infinity, Infinity];
  const high: Corner = [-Infinity, -Infinity, -Infinity];
  for (let body = 0; body < recording.bodies; ++body) {
    const radius = scene.features[body]?.radius_m ?? 0;
    const end = recording.endSegment(body);
    for (let i = recording.firstSegment(body); i < end; ++i) {
      if (i + 1 < end && segments.startS[i + 1]! <= fromS) continue;
      const duration = i + 1 < end ? segments.startS[i + 1]! - segments.startS[i]! : 0;
      for (const k of AXES) {
        const p = segments.position[3 * i + k]!;
        const v = segments.velocity[3 * i + k]!;
        const a = segments.acceleration[3 * i + k]!;
        const turning = a === 0 ? 0 : -v / a;
        const s = turning > 0 && turning < duration ? turning : 0;
        const at = p + v * s + 0.5 * a * s * s;
        low[k] = Math.min(low[k], p - radius, at - radius);
        high[k] = Math.max(high[k], p + radius, at + radius);
      }
    }
  }
  return { low, high };
}

/** The frame for a motion; the scene's whole view if there is no motion. */
export function framed(scene: Scene, looks: ViewBox, motion: ViewBox): ViewBox {
  const view: ViewBox = { low: scene.view_low_m, high: scene.view_high_m };
  const box = within(union(looks, motion), view);
  return isEmpty(box) || isEmpty(motion) ? view : box;
}

/** A frame shared by many pictures; it grows to contain each motion. */
export class SharedFrame {
  private motion = NOTHING;
  private current: ViewBox;
  /** The box of looks that all animations share. */
  readonly looks: ViewBox;

  constructor(private readonly scene: Scene, looks: Looks) {
    this.looks = boxOfLooks(scene, looks.meshes);
    this.current = { low: scene.view_low_m, high: scene.view_high_m };
  }

  get box(): ViewBox { return this.current; }

  /** Returns true if the frame changed, so that its pictures must be drawn again. */
  include(motion: ViewBox): boolean {
    const isFirst = isEmpty(this.motion);
    this.motion = union(this.motion, motion);
    const wanted = framed(this.scene, this.looks, this.motion);
    if (!isFirst && holds(this.current, wanted)) return false;
    this.current = isFirst ? wanted : framed(this.scene, this.looks, grown(this.motion));
    return true;
  }
}

function grown(box: ViewBox): ViewBox {
  const low: Corner = [...box.low];
  const high: Corner = [...box.high];
  for (const k of AXES) {
    const more = GROW * (high[k] - low[k]);
    low[k] -= more;
    high[k] += more;
  }
  return { low, high };
}
