// Pictures to click in a step's form: coloured swatches for bodies, and a map of named places from above. The
// pictures are shortcuts for the fields beside them.
import type { Looks, Scene } from "../data/types";
import { namedPlaces, numbersOf, type NamedPlace } from "../state/places";
import { button, el } from "./dom";

/** With more buttons the pictures would be too small. */
const buttonsMax = 40;

/** null if the swatches' labels are too short to tell the bodies apart. */
export function bodySwatches(
  scene: Scene,
  looks: Looks,
  onChoose: (name: string) => void,
): HTMLElement | null {
  const bodies = scene.features.flatMap(({ name, kind }, feature) =>
    kind === "body" ? [{ name, colour: looks.meshes.find((mesh) => mesh.feature === feature)?.colour }] : [],
  );
  const numbers = numbersOf(bodies.map(({ name }) => name));
  if (numbers === null || bodies.length < 2 || bodies.length > buttonsMax) return null;
  const swatches = bodies.map(({ name, colour }, i) => {
    const swatch = button(numbers[i] ?? "", () => onChoose(name), {
      class: "swatch",
      title: name,
      "aria-label": name,
      "data-body": name,
    });
    if (colour !== undefined) {
      swatch.style.backgroundColor = colour;
      swatch.style.color = isLight(colour) ? "#000" : "#fff";
    }
    return swatch;
  });
  const group = { class: "swatches", role: "group", "aria-label": "Bodies by colour" };
  return el("div", group, ...swatches);
}

/** null if there are no named places. */
export function placeMap(
  scene: Scene,
  looks: Looks,
  onChoose: (place: NamedPlace) => void,
): HTMLElement | null {
  const places = namedPlaces(scene, looks);
  if (places.length === 0 || places.length > buttonsMax) return null;
  const [only] = places;
  if (places.length === 1 && only !== undefined)
    return button(`Place: ${only.name}`, () => onChoose(only), {
      class: "small",
      "data-place": only.name,
    });
  const numbers = numbersOf(places.map(({ name }) => name));
  const left = Math.min(...places.map(({ x }) => x.low));
  const right = Math.max(...places.map(({ x }) => x.high));
  const near = Math.min(...places.map(({ y }) => y.low));
  const far = Math.max(...places.map(({ y }) => y.high));
  const map = el("div", { class: "place-map", role: "group", "aria-label": "Places, from above" });
  map.style.aspectRatio = String(Math.min(4, Math.max(0.25, (right - left) / (far - near))));
  for (const [i, place] of places.entries()) {
    const of = button(numbers?.[i] ?? place.name, () => onChoose(place), {
      class: "place",
      title: place.name,
      "aria-label": place.name,
      "data-place": place.name,
    });
    const percent = (value: number, whole: number): string => `${(100 * value) / whole}%`;
    of.style.left = percent(place.x.low - left, right - left);
    of.style.width = percent(place.x.high - place.x.low, right - left);
    of.style.top = percent(far - place.y.high, far - near);
    of.style.height = percent(place.y.high - place.y.low, far - near);
    map.append(of);
  }
  return map;
}

/** Whether black text is more readable on this colour than white text. */
function isLight(colour: string): boolean {
  const [red, green, blue] = [1, 3, 5].map((at) => {
    const value = Number.parseInt(colour.slice(at, at + 2), 16) / 255;
    return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * (red ?? 0) + 0.7152 * (green ?? 0) + 0.0722 * (blue ?? 0) > 0.179;
}
