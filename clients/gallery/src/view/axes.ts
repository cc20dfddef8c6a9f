// Converts the scene's axes (z up) to three.js's (y up), as clients/export/axes.h does for glTF: (x, y, z)
// becomes (x, z, -y), without rounding.

import type { Vector3 } from "three";
import type { Place } from "../data/types";

export function setYUp(out: Vector3, place: Place): Vector3 {
  return out.set(place[0], place[2], -place[1]);
}

export function zUp(of: Vector3): Place {
  return [of.x, -of.z, of.y];
}

/** Same as setYUp(), for separate coordinates. */
export function setYUpOf(out: Vector3, x: number, y: number, z: number): Vector3 {
  return out.set(x, z, -y);
}
