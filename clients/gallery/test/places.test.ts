import assert from "node:assert/strict";
import { test } from "node:test";
import type { Looks, Mesh, Scene } from "../src/data/types";
import { boxOfPlace, namedPlaces, numbersOf } from "../src/state/places";

function flat(feature: number, low: [number, number], high: [number, number]): Mesh {
  // Looks have y up: the scene's y is the look's -z.
  const places = new Float32Array([low[0], 0, -low[1], high[0], 0, -low[1], high[0], 0, -high[1]]);
  const common = { colour: "#f4b8a0", opacity: 1, doubleSided: true };
  return { feature, ...common, places, normals: places, corners: new Uint32Array([0, 1, 2]) };
}

function sceneOf(kinds: readonly ("body" | "fixed" | "wanted")[]): Scene {
  const features = kinds.map((kind, i) => ({ name: `thing ${i}`, kind, radius_m: 0 }));
  return { features } as unknown as Scene;
}

test("a place has the x and y ranges of its feature; only wanted features on the ground are places", () => {
  const looks: Looks = {
    meshes: [flat(0, [0, 0], [1, 1]), flat(2, [-0.054, 0.034], [-0.034, 0.054]), flat(3, [0, 0], [0, 0.1])],
  };
  const places = namedPlaces(sceneOf(["body", "fixed", "wanted", "wanted"]), looks);
  assert.deepEqual(places, [
    { name: "thing 2", x: { low: -0.054, high: -0.034 }, y: { low: 0.034, high: 0.054 } },
  ]);
  assert.deepEqual(boxOfPlace(places[0]!).z, { low: null, high: null });
});

test("numbers in names serve as labels if they are distinct", () => {
  assert.deepEqual(numbersOf(["ball 1", "ball 12"]), ["1", "12"]);
  assert.equal(numbersOf(["ball 1", "die 1"]), null);
  assert.equal(numbersOf(["ball", "die 1"]), null);
});
