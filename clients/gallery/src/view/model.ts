// The parts of an archive's stage that belong to one animation: its look, trails and marks.

import { Group } from "three";
import type { Animation } from "../data/types";
import { eventsOf, type MotionEvent } from "../motion/events";
import { Bodies } from "./bodies";
import type { ViewBox } from "./camera";
import { Contacts } from "./contacts";
import { boxOfLooks, boxOfMotion, framed, union } from "./framing";
import type { Merged } from "./geometry";
import { Marks } from "./marks";
import { type ArchiveStage, meshOf } from "./stage";
import { Trails } from "./trails";

export class AnimationModel {
  readonly group = new Group();
  /** The static part of the look. */
  readonly standing = new Group();
  /** Static features whose look is specific to this animation. */
  readonly ownStill: readonly Merged[];
  readonly ownBodies: Bodies | null;
  private madeTrails: Trails | null = null;
  private madeMarks: Marks | null = null;
  /** Whether no body moves along y. */
  readonly isPlanar: boolean;
  /** The interesting part of the scene. */
  readonly box: ViewBox;
  private madeEvents: readonly MotionEvent[] | null = null;

  constructor(readonly stage: ArchiveStage, readonly animation: Animation) {
    this.isPlanar = animation.recording.isPlanar();
    const looks = union(stage.frame.looks, boxOfLooks(stage.scene, animation.meshes));
    this.box = framed(stage.scene, looks, boxOfMotion(animation.recording, stage.scene));
    this.ownStill = stage.stillOf(animation.meshes);
    const bodies = animation.meshes.filter((mesh) => stage.isBody(mesh));
    this.ownBodies = bodies.length > 0 ? new Bodies(bodies, stage.bodyCount, "solid", stage.light) : null;
    for (const merged of this.ownStill) this.standing.add(meshOf(merged));
    this.group.add(this.standing);
    if (this.ownBodies !== null) this.group.add(this.ownBodies.group);
  }

  get events(): readonly MotionEvent[] {
    this.madeEvents ??= eventsOf(this.animation.recording);
    return this.madeEvents;
  }

  /** Created at the first use, because most thumbnails never show trails. */
  get trails(): Trails {
    if (this.madeTrails === null) {
      this.madeTrails = new Trails(this.animation.recording, this.stage, this.animation.meshes);
      this.group.add(this.madeTrails.lines);
    }
    return this.madeTrails;
  }

  private get contacts(): Contacts {
    const { recording, meshes } = this.animation;
    return new Contacts(recording, [...this.stage.looks.meshes, ...meshes]);
  }

  get marks(): Marks {
    if (this.madeMarks === null) {
      this.madeMarks = new Marks(this.events, this.contacts);
      this.group.add(this.madeMarks.points);
    }
    return this.madeMarks;
  }

  hideTrails(): void { if (this.madeTrails !== null) this.madeTrails.lines.visible = false; }
  hideMarks(): void { if (this.madeMarks !== null) this.madeMarks.points.visible = false; }

  dispose(): void {
    this.stage.leave(this);
    for (const { geometry } of this.ownStill) geometry.dispose();
    this.ownBodies?.dispose();
    this.madeTrails?.dispose();
    this.madeMarks?.dispose();
  }
}
