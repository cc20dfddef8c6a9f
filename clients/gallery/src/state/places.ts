// Named places of the scene, where bodies are wanted. A query's box can be set to such a place.
import type { Looks, Scene } from "../data/types";
import { openRange, type Box, type Range } from "./conditions";

export interface NamedPlace {
  readonly name: string;
  /** Extent seen from above, in metres. */
  readonly x: Range & { readonly low: number; readonly high: number };
  readonly y: Range & { readonly low: number; readonly high: number };
}

/** Thinner features aren't something to rest on. */
const thinM = 1e-3;

/** Places that all animations share, with an extent along x and y. */
export function namedPlaces(scene: Scene, looks: Looks): NamedPlace[] {
  return scene.features.flatMap(({ name, kind }, feature) => {
    if (kind !== "wanted") return [];
    // Looks have y up: the scene's (x, y, z) is the look's (x, z, -y).
    const x = extent(looks, feature, 0, 1);
    const y = extent(looks, feature, 2, -1);
    return x === null || y === null ? [] : [{ name, x, y }];
  });
}

/** A box of unlimited height above the place. */
export function boxOfPlace({ x, y }: NamedPlace): Box {
  return { x, y, z: openRange };
}

/** The names' final numbers, as short labels for buttons; null if a name has none. */
export function numbersOf(names: readonly string[]): string[] | null {
  const numbers = names.map((name) => /\d+$/.exec(name)?.[0] ?? "");
  return numbers.includes("") || new Set(numbers).size < numbers.length ? null : numbers;
}

function extent(
  looks: Looks,
  feature: number,
  component: 0 | 2,
  sign: 1 | -1,
): { low: number; high: number } | null {
  let low = Infinity;
  let high = -Infinity;
  for (const mesh of looks.meshes) {
    if (mesh.feature !== feature) continue;
    for (let i = component; i < mesh.places.length; i += 3) {
      // The numbers are rounded, because floats would print many digits.
      const value = Math.round((mesh.places[i] ?? NaN) * sign * 1e6) / 1e6;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  }
  return high - low > thinM ? { low, high } : null;
}
