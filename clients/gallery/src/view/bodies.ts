// Draws the bodies of a scene at one moment. Bodies of the same shape are instances of one mesh with their
// own colours, so that a hundred balls take one GPU call.

import { Color, DynamicDrawUsage, Group, InstancedMesh, type ShaderMaterial } from "three";
import type { Mesh } from "../data/types";
import { Pose } from "../motion/pose";
import type { Recording } from "../motion/recording";
import { geometryOf, isSameShape } from "./geometry";
import { type Light, shaded } from "./shading";

const GHOST_OPACITY = 0.3;

export type BodyStyle = "solid" | "ghost";

interface Batch {
  readonly mesh: InstancedMesh;
  readonly bodies: readonly number[];
  readonly colours: readonly Color[];
}

const pose = new Pose();

export class Bodies {
  readonly group = new Group();
  private readonly batches: Batch[];
  /** Per body: a matrix of sixteen numbers, column by column, and whether the body is present. */
  private readonly matrices: Float32Array;
  private readonly isThere: Uint8Array;

  /** `meshes`: meshes of bodies only. */
  constructor(meshes: readonly Mesh[], private readonly count: number, style: BodyStyle, light: Light) {
    this.matrices = new Float32Array(16 * count);
    this.isThere = new Uint8Array(count);
    this.batches = batchesOf(meshes, style, light);
    for (const batch of this.batches) this.group.add(batch.mesh);
  }

  /** Doesn't allocate. `only`: hides all other bodies. */
  place(recording: Recording, t: number, only: number | null = null): void {
    const count = Math.min(this.count, recording.bodies);
    this.isThere.fill(0);
    for (let body = 0; body < count; ++body) {
      if (only !== null && body !== only) continue;
      if (!recording.poseAt(body, t, pose)) continue;
      this.isThere[body] = 1;
      writeMatrix(this.matrices, 16 * body);
    }
    for (const batch of this.batches) this.fill(batch);
  }

  private fill(batch: Batch): void {
    const { mesh, bodies, colours } = batch;
    const into = mesh.instanceMatrix.array;
    const tints = mesh.instanceColor!.array;
    let shown = 0;
    for (let i = 0; i < bodies.length; ++i) {
      const body = bodies[i]!;
      if (this.isThere[body] === 0) continue;
      for (let k = 0; k < 16; ++k) into[16 * shown + k] = this.matrices[16 * body + k]!;
      const colour = colours[i]!;
      tints[3 * shown] = colour.r;
      tints[3 * shown + 1] = colour.g;
      tints[3 * shown + 2] = colour.b;
      ++shown;
    }
    mesh.count = shown;
    mesh.visible = shown > 0;
    mesh.instanceMatrix.needsUpdate = true;
    mesh.instanceColor!.needsUpdate = true;
  }

  dispose(): void {
    for (const { mesh } of this.batches) {
      mesh.geometry.dispose();
      (mesh.material as ShaderMaterial).dispose();
      mesh.dispose();
    }
  }
}

function batchesOf(meshes: readonly Mesh[], style: BodyStyle, light: Light): Batch[] {
  const shapes: { first: Mesh; meshes: Mesh[] }[] = [];
  for (const mesh of meshes) {
    const found = shapes.find(({ first }) =>
      first.opacity === mesh.opacity && first.doubleSided === mesh.doubleSided && isSameShape(first, mesh));
    if (found === undefined) shapes.push({ first: mesh, meshes: [mesh] });
    else found.meshes.push(mesh);
  }
  return shapes.map(({ first, meshes: same }) => ({
    mesh: instanced(first, same.length, style, light),
    bodies: same.map((mesh) => mesh.feature),
    colours: same.map((mesh) => new Color(mesh.colour)),
  }));
}

function instanced(look: Mesh, count: number, style: BodyStyle, light: Light): InstancedMesh {
  const opacity = style === "ghost" ? GHOST_OPACITY : look.opacity;
  const { doubleSided } = look;
  // Instances have their own colours.
  const material = shaded(light, { colour: "#ffffff", opacity, doubleSided, isDecal: false });
  const mesh = new InstancedMesh(geometryOf(look), material, count);
  mesh.setColorAt(0, new Color(1, 1, 1));
  mesh.instanceMatrix.setUsage(DynamicDrawUsage);
  mesh.frustumCulled = false;
  mesh.renderOrder = style === "ghost" ? 2 : 0;
  return mesh;
}

/** Writes the matrix of `pose` in y-up axes, column by column. */
function writeMatrix(into: Float32Array, at: number): void {
  const x = pose.qx, y = pose.qz, z = -pose.qy, w = pose.qw;
  const xx = x * x, yy = y * y, zz = z * z, xy = x * y, xz = x * z, yz = y * z;
  const wx = w * x, wy = w * y, wz = w * z;
  into[at] = 1 - 2 * (yy + zz);
  into[at + 1] = 2 * (xy + wz);
  into[at + 2] = 2 * (xz - wy);
  into[at + 3] = 0;
  into[at + 4] = 2 * (xy - wz);
  into[at + 5] = 1 - 2 * (xx + zz);
  into[at + 6] = 2 * (yz + wx);
  into[at + 7] = 0;
  into[at + 8] = 2 * (xz + wy);
  into[at + 9] = 2 * (yz - wx);
  into[at + 10] = 1 - 2 * (xx + yy);
  into[at + 11] = 0;
  into[at + 12] = pose.x;
  into[at + 13] = pose.z;
  into[at + 14] = -pose.y;
  into[at + 15] = 1;
}
