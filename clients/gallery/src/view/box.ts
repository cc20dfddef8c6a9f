// A box that people draw and resize in the scene, to find animations that pass through it. Pure geometry;
// box-drawer.ts shows the box.

import type { Place } from "../data/types";
import { middleOf, type ViewBox } from "./camera";

/** In metres, in the scene's frame (z up); low < high on each axis. */
export interface Box {
  readonly low: Place;
  readonly high: Place;
}

/** One of six faces: axis 0, 1 or 2, lower or upper. */
export interface Face {
  readonly axis: 0 | 1 | 2;
  readonly isHigh: boolean;
}

export const FACES: readonly Face[] = ([0, 1, 2] as const).flatMap((axis) =>
  [{ axis, isHigh: false }, { axis, isHigh: true }]);

export interface Ray {
  readonly origin: Place;
  /** A unit vector. */
  readonly direction: Place;
}

/** Coordinates are rounded to this, so that numbers in fields are short. */
const GRID_M = 1e-4;
/** Minimum thickness of a box. */
const THIN_M = 1e-3;

export function faceMiddle(box: Box, face: Face): Place {
  const place: [number, number, number] = [...middleOf(box)];
  place[face.axis] = (face.isHigh ? box.high : box.low)[face.axis];
  return place;
}

export function withFace(box: Box, face: Face, at: number): Box {
  const low: [number, number, number] = [...box.low];
  const high: [number, number, number] = [...box.high];
  const { axis } = face;
  if (face.isHigh) high[axis] = Math.max(rounded(at), low[axis] + THIN_M);
  else low[axis] = Math.min(rounded(at), high[axis] - THIN_M);
  return { low, high };
}

/** The point where the ray meets the plane with coordinate `at` on `axis`; null: none. */
export function onPlane(ray: Ray, axis: 0 | 1 | 2, at: number): Place | null {
  const slope = ray.direction[axis];
  if (Math.abs(slope) < 1e-6) return null;
  const s = (at - ray.origin[axis]) / slope;
  if (s <= 0) return null;
  return [
    ray.origin[0] + s * ray.direction[0], ray.origin[1] + s * ray.direction[1],
    ray.origin[2] + s * ray.direction[2],
  ];
}

/** The coordinate on the line through `middle` along `axis` where the line is nearest to the ray. */
export function alongAxis(ray: Ray, middle: Place, axis: 0 | 1 | 2): number | null {
  const d = ray.direction;
  const b = d[axis];
  const divisor = 1 - b * b;
  // The ray is almost parallel to the axis, so the coordinate is undefined.
  if (divisor < 1e-4) return null;
  const w: Place = [middle[0] - ray.origin[0], middle[1] - ray.origin[1], middle[2] - ray.origin[2]];
  const along = w[0] * d[0] + w[1] * d[1] + w[2] * d[2];
  return middle[axis] + (b * along - w[axis]) / divisor;
}

/** A new box from a drag on the ground (axis 2) or on the plane that faces a viewer at the front (axis 1).
 *  Along this axis the box has the size of the scene's view. */
export function dragged(from: Place, to: Place, axis: 1 | 2, view: ViewBox): Box {
  const low: [number, number, number] = [0, 0, 0];
  const high: [number, number, number] = [0, 0, 0];
  for (const k of [0, 1, 2] as const) {
    const a = k === axis ? view.low[k] : Math.min(from[k], to[k]);
    const b = k === axis ? view.high[k] : Math.max(from[k], to[k]);
    low[k] = rounded(a);
    high[k] = Math.max(rounded(b), low[k] + THIN_M);
  }
  return { low, high };
}

/** The box with ordered corners at least THIN_M apart; null if a number isn't finite. */
export function soundBox(box: Box): Box | null {
  if (![...box.low, ...box.high].every(Number.isFinite)) return null;
  const low: [number, number, number] = [0, 0, 0];
  const high: [number, number, number] = [0, 0, 0];
  for (const k of [0, 1, 2] as const) {
    low[k] = Math.min(box.low[k], box.high[k]);
    high[k] = Math.max(Math.max(box.low[k], box.high[k]), low[k] + THIN_M);
  }
  return { low, high };
}

function rounded(value: number): number {
  return Math.round(value / GRID_M) * GRID_M;
}
