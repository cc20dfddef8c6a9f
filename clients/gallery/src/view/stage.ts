// The parts that an archive's animations share: light, static features and bodies. The stage contains one
// animation at a time; show() prepares it for drawing at a given time.

import { Group, Mesh, Scene as ThreeScene } from "three";
import type { Looks, Mesh as MeshData, Scene } from "../data/types";
import type { Recording } from "../motion/recording";
import { Bodies } from "./bodies";
import { type ViewBox } from "./camera";
import { SharedFrame } from "./framing";
import { Materials, type Merged, mergedOf } from "./geometry";
import type { AnimationModel } from "./model";
import { Light } from "./shading";
import { THEMES, type Theme, type ThemeName } from "./theme";

/** Another animation's bodies, drawn transparently. */
export interface GhostAt {
  readonly recording: Recording;
  readonly t: number;
}

export class ArchiveStage {
  readonly three = new ThreeScene();
  /** The whole view. */
  readonly box: ViewBox;
  /** The frame shared by pictures of many animations. */
  readonly frame: SharedFrame;
  readonly bodyCount: number;
  readonly light = new Light();
  readonly materials = new Materials(this.light);
  private readonly fixed: readonly Merged[];
  private readonly bodies: Bodies;
  private ghosts: Bodies | null = null;
  private readonly slot = new Group();
  private shown: AnimationModel | null = null;
  private theme: Theme = THEMES.light;
  /** The archive's static features. */
  private readonly standing = new Group();

  constructor(readonly scene: Scene, readonly looks: Looks) {
    this.box = { low: scene.view_low_m, high: scene.view_high_m };
    this.frame = new SharedFrame(scene, looks);
    this.bodyCount = scene.features.filter((feature) => feature.kind === "body").length;
    this.fixed = this.stillOf(looks.meshes);
    const bodies = looks.meshes.filter((mesh) => this.isBody(mesh));
    this.bodies = new Bodies(bodies, this.bodyCount, "solid", this.light);
    for (const merged of this.fixed) this.standing.add(meshOf(merged));
    this.three.add(this.bodies.group, this.slot, this.standing);
    this.setTheme("light");
  }

  isBody(mesh: MeshData): boolean { return mesh.feature < this.bodyCount; }
  isGoal(feature: number): boolean { return this.scene.features[feature]?.kind === "wanted"; }

  /** Static features, merged by material. */
  stillOf(meshes: readonly MeshData[]): Merged[] {
    return mergedOf(meshes.filter((mesh) => !this.isBody(mesh)), this.materials,
      (feature) => this.isGoal(feature));
  }

  setTheme(name: ThemeName): void {
    this.theme = THEMES[name];
    this.light.set(this.theme);
  }

  /** Puts the animation onto the stage, at its own time t. `only`: shows only this body. */
  show(model: AnimationModel, t: number, ghost: GhostAt | null = null, only: number | null = null): void {
    if (this.shown !== model) {
      this.slot.clear();
      this.slot.add(model.group);
      this.shown = model;
    }
    this.standing.visible = only === null;
    model.standing.visible = only === null;
    this.bodies.place(model.animation.recording, t, only);
    model.ownBodies?.place(model.animation.recording, t, only);
    if (ghost === null) {
      if (this.ghosts !== null) this.ghosts.group.visible = false;
      return;
    }
    const ghosts = this.ghosts ?? this.madeGhosts();
    ghosts.group.visible = true;
    ghosts.place(ghost.recording, ghost.t);
  }

  /** The merged meshes of the archive and of one animation, for picking. */
  still(model: AnimationModel): readonly Merged[] { return [...this.fixed, ...model.ownStill]; }

  /** Removes the animation before its disposal. */
  leave(model: AnimationModel): void {
    if (this.shown !== model) return;
    this.slot.clear();
    this.shown = null;
  }

  dispose(): void {
    this.slot.clear();
    for (const { geometry } of this.fixed) geometry.dispose();
    this.bodies.dispose();
    this.ghosts?.dispose();
    this.materials.dispose();
  }

  private madeGhosts(): Bodies {
    const meshes = this.looks.meshes.filter((mesh) => this.isBody(mesh));
    this.ghosts = new Bodies(meshes, this.bodyCount, "ghost", this.light);
    this.three.add(this.ghosts.group);
    return this.ghosts;
  }
}

/** Transparent features are drawn after opaque ones. */
export function meshOf(merged: Merged): Mesh {
  const mesh = new Mesh(merged.geometry, merged.material);
  mesh.matrixAutoUpdate = false;
  mesh.renderOrder = merged.isClear ? 1 : 0;
  return mesh;
}
