// Rings where bodies hit something. Rings grow and fade; gentle hits have faint rings.

import { BufferAttribute, BufferGeometry, Color, DynamicDrawUsage, Points, ShaderMaterial } from "three";
import type { Place } from "../data/types";
import type { MotionEvent } from "../motion/events";
import type { Contacts } from "./contacts";

/** Duration of a mark. */
export const MARK_S = 0.3;
const SHOWN_MAX = 96;
/** Below this change of velocity, hits of a body that comes to rest are too many to mark. */
const CHANGE_MIN_MPS = 0.03;
/** Change of velocity with a mark of full strength. */
const CHANGE_FULL_MPS = 0.4;

const VERTEX = `
attribute vec2 look;
uniform float scale;
varying float alpha;
void main() {
  float age = look.x;
  alpha = (1.0 - age) * look.y;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  gl_PointSize = scale * (8.0 + (8.0 + 16.0 * look.y) * age);
}`;
const FRAGMENT = `
uniform vec3 colour;
varying float alpha;
void main() {
  float radius = 2.0 * length(gl_PointCoord - 0.5);
  float ring = smoothstep(0.62, 0.74, radius) * (1.0 - smoothstep(0.88, 1.0, radius));
  gl_FragColor = vec4(colour, ring * alpha);
  if (gl_FragColor.a < 0.02) discard;
  #include <colorspace_fragment>
}`;

interface Hit {
  readonly timeS: number;
  readonly place: Place;
  readonly strength: number;
}

export class Marks {
  readonly points: Points<BufferGeometry, ShaderMaterial>;
  private readonly hits: readonly Hit[];
  private readonly places = new BufferAttribute(new Float32Array(3 * SHOWN_MAX), 3);
  /** Age from 0 to 1, and strength. */
  private readonly looks = new BufferAttribute(new Float32Array(2 * SHOWN_MAX), 2);

  constructor(events: readonly MotionEvent[], contacts: Contacts) {
    this.hits = events
      .filter((event) => event.cause === "hit" && Math.hypot(...event.change_mps) >= CHANGE_MIN_MPS)
      .map((event) => ({
        timeS: event.timeS,
        place: contacts.placeOf(event),
        strength: Math.min(0.25 + Math.hypot(...event.change_mps) / CHANGE_FULL_MPS, 1),
      }));
    this.places.setUsage(DynamicDrawUsage);
    this.looks.setUsage(DynamicDrawUsage);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", this.places);
    geometry.setAttribute("look", this.looks);
    const material = new ShaderMaterial({
      vertexShader: VERTEX, fragmentShader: FRAGMENT, transparent: true, depthWrite: false, depthTest: false,
      uniforms: { colour: { value: new Color() }, scale: { value: 1 } },
    });
    this.points = new Points(geometry, material);
    this.points.frustumCulled = false;
    this.points.renderOrder = 3;
  }

  /** `ratio`: device pixels per CSS pixel. */
  show(t: number, colour: number, ratio: number): void {
    let count = 0;
    for (let i = this.lastBy(t); i >= 0 && count < SHOWN_MAX; --i) {
      const hit = this.hits[i]!;
      const age = (t - hit.timeS) / MARK_S;
      if (age >= 1) break;
      const [x, y, z] = hit.place;
      this.places.setXYZ(count, x, z, -y);
      this.looks.setXY(count, age, hit.strength);
      ++count;
    }
    this.points.visible = count > 0;
    this.points.geometry.setDrawRange(0, count);
    this.places.needsUpdate = true;
    this.looks.needsUpdate = true;
    (this.points.material.uniforms["colour"]!.value as Color).set(colour);
    this.points.material.uniforms["scale"]!.value = ratio;
  }

  dispose(): void {
    this.points.geometry.dispose();
    this.points.material.dispose();
  }

  /** The last hit at or before t; -1: none. */
  private lastBy(t: number): number {
    let low = 0;
    let high = this.hits.length;
    while (low < high) {
      const middle = (low + high) >>> 1;
      if (this.hits[middle]!.timeS > t) high = middle;
      else low = middle + 1;
    }
    return low - 1;
  }
}
