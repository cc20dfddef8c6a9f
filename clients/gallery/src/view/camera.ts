// The camera that orbits a scene. The camera's state is a few numbers, which links contain.

import { Matrix4, PerspectiveCamera, Vector3 } from "three";
import type { Place } from "../data/types";
import { setYUp } from "./axes";

export interface CameraState {
  /** Angle around the vertical: 0 is the front (a viewer at -y), counter-clockwise from above. */
  readonly azimuth: number;
  /** Angle above the horizon; a quarter turn looks straight down. */
  readonly elevation: number;
  /** 1: the scene's view fills the picture; 2: twice as large. */
  readonly zoom: number;
  /** Centre of the picture, in the scene's frame; null: the centre of the scene's view. */
  readonly target: Place | null;
}

export type Preset = "home" | "front" | "top" | "side";

/** The box that the camera frames. */
export interface ViewBox {
  readonly low: Place;
  readonly high: Place;
}

export const FIELD_OF_VIEW_RAD = (26 * Math.PI) / 180;
const ZOOM_MIN = 0.1;
const ZOOM_MAX = 200;
const QUARTER = Math.PI / 2;
/** The view's size including a margin, relative to the view. */
const MARGIN = 1.04;
/** Views thinner than this along y, relative to their other sizes, are seen from the front. */
const THIN = 0.34;

export function presetOf(preset: Preset, box: ViewBox, isPlanar: boolean): CameraState {
  const from = (azimuth: number, elevation: number): CameraState =>
    ({ azimuth, elevation, zoom: 1, target: null });
  switch (preset) {
    case "front": return from(0, 0);
    case "top": return from(0, QUARTER);
    case "side": return from(QUARTER, 0);
    case "home":
      if (isPlanar) return from(0, 0.1);
      return isThin(box) ? from(0.12, 0.55) : from(0.14, 1.0);
  }
}

export function isThin(box: ViewBox): boolean {
  const size = (axis: 0 | 1 | 2): number => box.high[axis] - box.low[axis];
  return size(1) < THIN * Math.max(size(0), size(2));
}

/** Clamps the numbers of a link or a drag to valid ranges. */
export function sound(camera: CameraState): CameraState {
  const turn = Number.isFinite(camera.azimuth) ? camera.azimuth : 0;
  const elevation = Number.isFinite(camera.elevation) ? camera.elevation : 0;
  const zoom = Number.isFinite(camera.zoom) ? camera.zoom : 1;
  return {
    azimuth: Math.atan2(Math.sin(turn), Math.cos(turn)),
    elevation: Math.min(Math.max(elevation, -QUARTER), QUARTER),
    zoom: Math.min(Math.max(zoom, ZOOM_MIN), ZOOM_MAX),
    target: camera.target !== null && camera.target.every(Number.isFinite) ? camera.target : null,
  };
}

export function middleOf(box: ViewBox): Place {
  return [
    0.5 * (box.low[0] + box.high[0]), 0.5 * (box.low[1] + box.high[1]), 0.5 * (box.low[2] + box.high[2]),
  ];
}

const right = new Vector3();
const up = new Vector3();
const back = new Vector3();
const centre = new Vector3();
const corner = new Vector3();
const basis = new Matrix4();

/** Axes of the picture in three.js's frame: right, up, and towards the viewer. */
export function axesOf(state: CameraState, toRight: Vector3, upwards: Vector3, towards: Vector3): void {
  const { azimuth: a, elevation: e } = state;
  toRight.set(Math.cos(a), 0, -Math.sin(a));
  towards.set(Math.sin(a) * Math.cos(e), Math.sin(e), Math.cos(a) * Math.cos(e));
  upwards.crossVectors(towards, toRight);
}

/** Places the camera for a picture of this aspect (width / height). Doesn't allocate. */
export function aim(camera: PerspectiveCamera, state: CameraState, box: ViewBox, aspect: number): void {
  axesOf(state, right, up, back);
  setYUp(centre, middleOf(box));
  const tangent = Math.tan(FIELD_OF_VIEW_RAD / 2);
  // The smallest distance at which all corners of the view are visible.
  let distance = 0;
  let radius = 0;
  for (let i = 0; i < 8; ++i) {
    corner.set(
      i & 1 ? box.high[0] : box.low[0], i & 4 ? box.high[2] : box.low[2], -(i & 2 ? box.high[1] : box.low[1]),
    ).sub(centre);
    radius = Math.max(radius, corner.length());
    const depth = corner.dot(back);
    distance = Math.max(
      distance,
      (MARGIN * Math.abs(corner.dot(up))) / tangent + depth,
      (MARGIN * Math.abs(corner.dot(right))) / (tangent * aspect) + depth,
    );
  }
  distance /= state.zoom;
  if (state.target !== null) setYUp(centre, state.target);
  basis.makeBasis(right, up, back);
  camera.quaternion.setFromRotationMatrix(basis);
  camera.position.copy(centre).addScaledVector(back, distance);
  camera.fov = (FIELD_OF_VIEW_RAD * 180) / Math.PI;
  camera.aspect = aspect;
  camera.near = Math.max(distance - 4 * radius, 0.02 * distance);
  camera.far = distance + 8 * radius;
  camera.updateProjectionMatrix();
  camera.updateMatrixWorld(true);
}
