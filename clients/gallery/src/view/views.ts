// The player's picture as cells. Each cell shows one animation, and all cells have the same direction of
// view. Converts points of the picture to rays and features, and places to points.
//
// Pixels are CSS pixels from the picture's upper left.

import { PerspectiveCamera, Vector3 } from "three";
import type { Place } from "../data/types";
import { setYUp, zUp } from "./axes";
import type { Ray } from "./box";
import {
  aim, axesOf, type CameraState, FIELD_OF_VIEW_RAD, middleOf, type Preset, presetOf, sound, type ViewBox,
} from "./camera";
import { type Cell, cellAt, cellsOf } from "./cells";
import { union } from "./framing";
import type { AnimationModel } from "./model";
import { featureUnder, type OnScreen, pixelsOf, projected, rayAt } from "./picking";

/** A point of the picture, within its cell. */
export interface PointInCell {
  readonly index: number;
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
  readonly ray: Ray;
}

const NOWHERE: OnScreen = { x: 0, y: 0, radiusPx: 0, visible: false };

const toRight = new Vector3();
const upwards = new Vector3();
const towards = new Vector3();
const target = new Vector3();

export class Views {
  models: readonly AnimationModel[] = [];
  cells: readonly Cell[] = [];
  /** The camera as aimAt() last placed it. */
  readonly eye = new PerspectiveCamera();
  private state: CameraState = { azimuth: 0, elevation: 0, zoom: 1, target: null };
  private isChosen = false;
  /** For each animation, the interesting part of all shown animations of its archive. */
  private boxes: readonly ViewBox[] = [];

  get camera(): CameraState { return this.state; }
  /** From now on the camera stays where a person put it. */
  setCamera(camera: CameraState): void {
    this.state = sound(camera);
    this.isChosen = true;
  }

  setModels(models: readonly AnimationModel[]): void {
    this.models = models;
    this.boxes = models.map((model) => models
      .filter((other) => other.stage === model.stage)
      .reduce((box, other) => union(box, other.box), model.box));
    if (!this.isChosen) this.state = this.preset("home");
  }

  layOut(width: number, height: number): void {
    this.cells = cellsOf(this.models.length, width, height);
  }

  preset(preset: Preset): CameraState {
    const model = this.models[0];
    if (model === undefined) return this.state;
    return presetOf(preset, model.stage.box, this.models.every(({ isPlanar }) => isPlanar));
  }

  /** The camera after the scene was pulled by these pixels to the right and down. */
  pulled(dx: number, dy: number): CameraState {
    const cell = this.cells[0];
    const box = this.boxes[0];
    if (cell === undefined || box === undefined) return this.state;
    this.aimAt(0);
    setYUp(target, this.state.target ?? middleOf(box));
    const depth = this.eye.position.distanceTo(target);
    const metres = (2 * depth * Math.tan(FIELD_OF_VIEW_RAD / 2)) / cell.height;
    axesOf(this.state, toRight, upwards, towards);
    target.addScaledVector(toRight, -dx * metres).addScaledVector(upwards, dy * metres);
    return { ...this.state, target: zUp(target) };
  }

  /** Places `eye` for the animation's cell. Doesn't allocate. */
  aimAt(index: number): void {
    const box = this.boxes[index];
    const cell = this.cells[index];
    if (box !== undefined && cell !== undefined) aim(this.eye, this.state, box, cell.width / cell.height);
  }

  /** null: the point is between cells. Aims `eye` at the cell. */
  pointAt(x: number, y: number, within: number | null = null): PointInCell | null {
    const index = within ?? cellAt(this.cells, x, y);
    const cell = this.cells[index];
    if (cell === undefined) return null;
    this.aimAt(index);
    const { width, height } = cell;
    const inX = x - cell.x;
    const inY = y - cell.y;
    return { index, x: inX, y: inY, width, height, ray: rayAt(this.eye, inX, inY, width, height) };
  }

  /** The feature under the point; -1: none. `t`: the animation's own time. */
  featureAt(point: PointInCell, t: number): number {
    const model = this.models[point.index];
    if (model === undefined) return -1;
    this.aimAt(point.index);
    return featureUnder(model, t, this.eye, point.x, point.y, point.width, point.height);
  }

  screenOf(index: number, place: Place, radiusM: number): OnScreen {
    const cell = this.cells[index];
    if (cell === undefined) return NOWHERE;
    this.aimAt(index);
    const at = projected(this.eye, place, cell.width, cell.height);
    if (at === null) return NOWHERE;
    const radiusPx = pixelsOf(radiusM, at.depth, cell.height);
    return { x: cell.x + at.x, y: cell.y + at.y, radiusPx, visible: true };
  }
}
