// Triangles for the GPU. Static features are merged by material; bodies of the same shape share triangles.

import { BufferAttribute, BufferGeometry, type Material, type ShaderMaterial } from "three";
import type { Mesh } from "../data/types";
import { type Light, shaded } from "./shading";

/** Maximum opacity of goals. */
const WANTED_OPACITY = 0.6;

export function geometryOf(mesh: Mesh): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(mesh.places, 3));
  geometry.setAttribute("normal", new BufferAttribute(mesh.normals, 3));
  geometry.setIndex(new BufferAttribute(mesh.corners, 1));
  return geometry;
}

/** Merged meshes of one material, with each triangle's feature. */
export interface Merged {
  readonly geometry: BufferGeometry;
  readonly material: Material;
  readonly isClear: boolean;
  /** First triangles of features, ascending. */
  readonly from: readonly { readonly triangle: number; readonly feature: number }[];
}

/** Materials by look, shared by everything drawn from an archive. */
export class Materials {
  private readonly byKey = new Map<string, ShaderMaterial>();

  constructor(private readonly light: Light) {}

  get(colour: string, opacity: number, doubleSided: boolean, isGoal: boolean): ShaderMaterial {
    const shown = isGoal ? Math.min(opacity, WANTED_OPACITY) : opacity;
    const key = `${colour} ${shown} ${doubleSided} ${isGoal}`;
    const found = this.byKey.get(key);
    if (found !== undefined) return found;
    const material = shaded(this.light, { colour, opacity: shown, doubleSided, isDecal: isGoal });
    this.byKey.set(key, material);
    return material;
  }

  dispose(): void {
    for (const material of this.byKey.values()) material.dispose();
    this.byKey.clear();
  }
}

export function mergedOf(
  meshes: readonly Mesh[], materials: Materials, isGoal: (feature: number) => boolean,
): Merged[] {
  const groups = new Map<Material, Mesh[]>();
  for (const mesh of meshes) {
    const material =
      materials.get(mesh.colour, mesh.opacity, mesh.doubleSided, isGoal(mesh.feature));
    const group = groups.get(material);
    if (group === undefined) groups.set(material, [mesh]);
    else group.push(mesh);
  }
  return [...groups].map(([material, group]) => merged(group, material));
}

function merged(meshes: readonly Mesh[], material: Material): Merged {
  const numbers = meshes.reduce((sum, mesh) => sum + mesh.places.length, 0);
  const places = new Float32Array(numbers);
  const normals = new Float32Array(numbers);
  const corners = new Uint32Array(meshes.reduce((sum, mesh) => sum + mesh.corners.length, 0));
  const from: { triangle: number; feature: number }[] = [];
  let at = 0;
  let cornerAt = 0;
  for (const mesh of meshes) {
    from.push({ triangle: cornerAt / 3, feature: mesh.feature });
    places.set(mesh.places, at);
    normals.set(mesh.normals, at);
    const base = at / 3;
    for (let i = 0; i < mesh.corners.length; ++i) corners[cornerAt + i] = base + mesh.corners[i]!;
    at += mesh.places.length;
    cornerAt += mesh.corners.length;
  }
  const geometry = geometryOf({
    feature: 0, colour: "", opacity: 1, doubleSided: false, places, normals, corners,
  });
  return { geometry, material, isClear: material.transparent, from };
}

/** The feature of a triangle of merged meshes. */
export function featureOf(merged: Pick<Merged, "from">, triangle: number): number {
  let feature = -1;
  for (const part of merged.from) {
    if (part.triangle > triangle) break;
    feature = part.feature;
  }
  return feature;
}

export function isSameShape(a: Mesh, b: Mesh): boolean {
  return isEqual(a.places, b.places) && isEqual(a.corners, b.corners) && isEqual(a.normals, b.normals);
}

function isEqual(a: Float32Array | Uint32Array, b: Float32Array | Uint32Array): boolean {
  if (a.length !== b.length) return false;
  for (let i = 0; i < a.length; ++i) if (a[i] !== b[i]) return false;
  return true;
}
