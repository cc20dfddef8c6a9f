// What a timeline shows of the player's animations: events by shared time, in words, and where two
// animations part.

import type { MotionEvent } from "../motion/events";
import { whereTheyPart } from "../motion/parting";
import type { AnimationModel } from "./model";
import type { Scene } from "../data/types";

export interface TimelineEvent extends MotionEvent {
  readonly sharedS: number;
  /** "die 1 hits table". */
  readonly words: string;
}

export interface TimelineItem {
  readonly label: string;
  /** The animation's own time = shared time + this. */
  readonly shiftS: number;
  /** Shared times at which it begins and at which all rests. */
  readonly startS: number;
  readonly endS: number;
  readonly events: readonly TimelineEvent[];
}

export interface Parting {
  /** Which two of the animations. */
  readonly a: number;
  readonly b: number;
  readonly sharedS: number;
}

export interface Timeline {
  readonly items: readonly TimelineItem[];
  /** Of each pair that parts, the first moment. */
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
      // Bodies of two archives needn't be the same ones.
      if (!haveSameBodies(models[a]!.stage.scene, models[b]!.stage.scene)) continue;
      const sharedS = whereTheyPart(of(a), of(b), toleranceM);
      if (sharedS !== null) parts.push({ a, b, sharedS });
    }
  }
  return { items: models.map((model, i) => itemOf(model, items[i]?.label ?? "", shifts[i]!)), parts };
}

/** A tenth of the bodies' mean radius, but no less than a millimetre. */
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
