// Finds what is under the pointer, and where features appear in a picture.

import { Matrix4, Mesh, type PerspectiveCamera, Raycaster, Vector2, Vector3 } from "three";
import type { Place } from "../data/types";
import { Pose } from "../motion/pose";
import { setYUpOf, zUp } from "./axes";
import type { Ray } from "./box";
import { FIELD_OF_VIEW_RAD } from "./camera";
import { featureOf, type Merged } from "./geometry";
import type { AnimationModel } from "./model";

/** Bodies are enlarged by this for picking, because small ones are hard to hit. */
const REACH_PX = 4;

export interface OnScreen {
  /** The body's centre, in CSS pixels from the canvas's upper left. */
  readonly x: number;
  readonly y: number;
  readonly radiusPx: number;
  /** False if the body hasn't entered or is behind the viewer. */
  readonly visible: boolean;
}

const pose = new Pose();
const place = new Vector3();
const raycaster = new Raycaster();
const pointer = new Vector2();

/** A ray through a point of a cell, in the scene's frame. */
export function rayAt(camera: PerspectiveCamera, x: number, y: number, width: number, height: number): Ray {
  pointer.set((2 * x) / width - 1, 1 - (2 * y) / height);
  raycaster.setFromCamera(pointer, camera);
  return { origin: zUp(raycaster.ray.origin), direction: zUp(raycaster.ray.direction) };
}

/** The nearest body that the ray meets; else the static feature; -1: nothing. */
export function featureUnder(
  model: AnimationModel, t: number, camera: PerspectiveCamera,
  x: number, y: number, width: number, height: number,
): number {
  const ray = rayAt(camera, x, y, width, height);
  const { features } = model.stage.scene;
  const pixel = Math.tan(FIELD_OF_VIEW_RAD / 2) / (height / 2);
  const { recording } = model.animation;
  const still = stillUnder(model.stage.still(model));
  let nearest = still.distance;
  let feature = still.feature;
  for (let body = 0; body < recording.bodies; ++body) {
    if (!recording.centreAt(body, t, pose)) continue;
    const [ox, oy, oz] = ray.origin;
    const [dx, dy, dz] = ray.direction;
    const wx = pose.x - ox, wy = pose.y - oy, wz = pose.z - oz;
    const along = wx * dx + wy * dy + wz * dz;
    const radius = features[body]?.radius_m ?? 0;
    const off = Math.hypot(wx - along * dx, wy - along * dy, wz - along * dz);
    if (along <= 0 || off > radius + REACH_PX * pixel * along) continue;
    const distance = along - Math.sqrt(Math.max(radius * radius - off * off, 0));
    // Static features hide a body only if they are in front by at least its size, because it may rest on them.
    if (distance >= nearest + 2 * radius && feature >= 0 && features[feature]?.kind !== "body") continue;
    if (features[feature]?.kind === "body" && distance >= nearest) continue;
    nearest = distance;
    feature = body;
  }
  return feature;
}

const identity = new Matrix4();

/** The static feature that `raycaster` meets. */
function stillUnder(merged: readonly Merged[]): { feature: number; distance: number } {
  let feature = -1;
  let distance = Infinity;
  for (const part of merged) {
    const mesh = new Mesh(part.geometry, part.material);
    mesh.matrixWorld.copy(identity);
    const hit = raycaster.intersectObject(mesh, false)[0];
    if (hit === undefined || hit.distance >= distance) continue;
    distance = hit.distance;
    feature = featureOf(part, hit.faceIndex ?? 0);
  }
  return { feature, distance };
}

/** Projects to CSS pixels within a cell; null: behind the viewer. */
export function projected(
  camera: PerspectiveCamera, at: Place, width: number, height: number,
): { x: number; y: number; depth: number } | null {
  setYUpOf(place, at[0], at[1], at[2]).applyMatrix4(camera.matrixWorldInverse);
  const depth = -place.z;
  if (depth <= 0) return null;
  place.applyMatrix4(camera.projectionMatrix);
  return { x: 0.5 * (place.x + 1) * width, y: 0.5 * (1 - place.y) * height, depth };
}

/** Size of a length at this depth, in pixels. */
export function pixelsOf(length: number, depth: number, height: number): number {
  return (0.5 * length * height) / (depth * Math.tan(FIELD_OF_VIEW_RAD / 2));
}
