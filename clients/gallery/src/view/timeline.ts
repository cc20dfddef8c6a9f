// The timeline's data: the animations' events by shared time, in words, and the times where two animations
// start to differ.

import type { MotionEvent } from "../motion/events";
import { whereTheyPart } from "../motion/parting";
import type { AnimationModel } from "./model";
import type { Scene } from "../data/types";

export interface TimelineEvent extends MotionEvent {
  readonly sharedS: number;
  /** Such as "die 1 hits table". */
  readonly words: string;
}

export interface TimelineItem {
  readonly label: string;
  /** The animation's own time is shared time + this shift. */
  readonly shiftS: number;
  /** Shared times of the animation's start and end. */
  readonly startS: number;
  readonly endS: number;
  readonly events: readonly TimelineEvent[];
}

export interface Parting {
  /** Indices of the two animations. */
  readonly a: number;
  readonly b: number;
  readonly sharedS: number;
}

export interface Timeline {
  readonly items: readonly TimelineItem[];
  /** The first difference of each pair that differs. */
  readonly parts: readonly Parting[];
}

const TOLERANCE_M_MIN = 1e-3;

export function timelineOf(
  items: readonly { readonly label: string }[], models: readonly AnimationModel[], shifts: readonly number[],
  toleranceM: number,
): Timeline {
  const parts: Parting[] = [];
  const of = (i: number) => ({ recording: models[i]!.animation.recording, shift: shifts[i]! });
  for (let a = 0; a < models.length; ++a) {
    for (let b = a + 1; b < models.length; ++b) {
      // Bodies of different archives may not be comparable.
      if (!haveSameBodies(models[a]!.stage.scene, models[b]!.stage.scene)) continue;
      const sharedS = whereTheyPart(of(a), of(b), toleranceM);
      if (sharedS !== null) parts.push({ a, b, sharedS });
    }
  }
  return { items: models.map((model, i) => itemOf(model, items[i]?.label ?? "", shifts[i]!)), parts };
}

/** A tenth of the bodies' mean radius, but at least a millimetre. */
export function toleranceOf(models: readonly AnimationModel[]): number {
  let sum = 0;
  let count = 0;
  for (const { stage } of models) {
    for (let body = 0; body < stage.bodyCount; ++body) {
      sum += stage.scene.features[body]?.radius_m ?? 0;
      ++count;
    }
  }
  return Math.max(TOLERANCE_M_MIN, count > 0 ? (0.1 * sum) / count : 0);
}

function itemOf(model: AnimationModel, label: string, shiftS: number): TimelineItem {
  const { recording } = model.animation;
  return {
    label,
    shiftS,
    startS: -shiftS,
    endS: recording.endS - shiftS,
    events: model.events.map((event) =>
      ({ ...event, sharedS: event.timeS - shiftS, words: wordsOf(event, model.stage.scene) })),
  };
}

export function wordsOf(event: MotionEvent, scene: Scene): string {
  const name = (feature: number): string => scene.features[feature]?.name ?? "something";
  const body = name(event.body);
  switch (event.cause) {
    case "start": return `${body} enters`;
    case "hit": return `${body} hits ${name(event.partner)}`;
    case "rest": return event.mode === "resting" ? `${body} comes to rest` : `${body} starts to move`;
    case "mode":
      switch (event.mode) {
        case "flying": return `${body} starts to fly`;
        case "sliding": return `${body} starts to slide`;
        case "rolling": return `${body} starts to roll`;
        case "resting": return `${body} comes to rest`;
      }
  }
}

function haveSameBodies(a: Scene, b: Scene): boolean {
  if (a === b) return true;
  const names = (scene: Scene): string =>
    JSON.stringify(scene.features.filter(({ kind }) => kind === "body").map(({ name }) => name));
  return names(a) === names(b);
}
