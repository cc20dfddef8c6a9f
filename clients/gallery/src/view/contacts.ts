// Estimates where a body touched what it hit: at the body's furthest point opposite to its change of
// velocity. The estimate for a ball is exact except for friction; for a die, it is the correct corner.

import type { Mesh, Place } from "../data/types";
import type { MotionEvent } from "../motion/events";
import { Pose } from "../motion/pose";
import type { Recording } from "../motion/recording";

const pose = new Pose();

export class Contacts {
  /** Vertices of each body's meshes; y up, in the body's frame. */
  private readonly vertices: readonly Float32Array[][];

  constructor(private readonly recording: Recording, meshes: readonly Mesh[]) {
    this.vertices = Array.from({ length: recording.bodies }, () => []);
    for (const mesh of meshes) this.vertices[mesh.feature]?.push(mesh.places);
  }

  /** The contact point in the scene's frame. */
  placeOf(hit: MotionEvent): Place {
    const [cx, cy, cz] = hit.change_mps;
    if (!this.recording.poseAt(hit.body, hit.timeS, pose)) return hit.place_m;
    // Rotate the direction into the body's frame, by the inverse rotation.
    const d = rotated(-pose.qx, -pose.qy, -pose.qz, pose.qw, cx, cy, cz);
    let least = Infinity;
    let touching: Place = [0, 0, 0];
    for (const places of this.vertices[hit.body] ?? []) {
      for (let i = 0; i < places.length; i += 3) {
        const x = places[i]!, y = -places[i + 2]!, z = places[i + 1]!;
        const along = x * d[0] + y * d[1] + z * d[2];
        if (along >= least) continue;
        least = along;
        touching = [x, y, z];
      }
    }
    const [tx, ty, tz] = rotated(pose.qx, pose.qy, pose.qz, pose.qw, ...touching);
    return [hit.place_m[0] + tx, hit.place_m[1] + ty, hit.place_m[2] + tz];
  }
}

function rotated(
  qx: number, qy: number, qz: number, qw: number, x: number, y: number, z: number,
): [number, number, number] {
  const tx = 2 * (qy * z - qz * y);
  const ty = 2 * (qz * x - qx * z);
  const tz = 2 * (qx * y - qy * x);
  return [
    x + qw * tx + (qy * tz - qz * ty), y + qw * ty + (qz * tx - qx * tz), z + qw * tz + (qx * ty - qy * tx),
  ];
}
