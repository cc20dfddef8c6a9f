// Resemblance of two animations, from their recordings alone. clients/browse/resemblance.h has the formula
// and its reasons. The same operations in the same order yield the same bits.

import { cheapestMatching } from "./matching";
import type { SearchIndex } from "./search-index";
import { FIRST_CONTACTS_MAX, keyOf, MATCHING_TIMES, type Sketch, TIMES } from "./sketch";

export class Resemblance {
  /** Classes of interchangeable bodies. */
  private readonly twins: readonly Uint32Array[];
  /** Distance between a body that enters and one that never enters. */
  private readonly apartM: number;
  private readonly bodies: number;
  private readonly features: number;
  /** Scratch memory: b's body that is matched with each of a's bodies. */
  private readonly partnerOf: Uint32Array;
  private readonly columnOf: Int32Array;
  private readonly costs: Float64Array;
  private readonly apart = new Float32Array(TIMES);

  constructor(index: SearchIndex) {
    const classes = new Map<number, number[]>();
    for (let body = 0; body < index.bodies; ++body) {
      const first = index.features[body]!.twin_of;
      classes.set(first, [...(classes.get(first) ?? []), body]);
    }
    const ascending = [...classes].sort(([a], [b]) => a - b);
    this.twins = ascending.map(([, bodies]) => Uint32Array.from(bodies));
    const { view_low_m: low, view_high_m: high } = index.view;
    const [x, y, z] = [high[0] - low[0], high[1] - low[1], high[2] - low[2]];
    this.apartM = Math.sqrt(x * x + y * y + z * z);
    this.bodies = index.bodies;
    this.features = index.features.length;
    this.partnerOf = new Uint32Array(index.bodies);
    const most = Math.max(0, ...this.twins.map((bodies) => bodies.length));
    this.columnOf = new Int32Array(most);
    this.costs = new Float64Array(most * most);
  }

  /** Distance in metres. REQUIRES: a comes before b in the compared list. */
  valueM(a: Sketch, b: Sketch): number {
    this.match(a, b);
    let meanM = 0;
    let greatestM = 0;
    for (let body = 0; body < this.bodies; ++body) {
      const other = this.partnerOf[body]!;
      let sum = 0;
      let greatest = 0;
      if (a.enters[body] !== b.enters[other]) {
        sum = this.apartM * TIMES;
        greatest = this.apartM;
      } else {
        [sum, greatest] = this.apartOf(a.places, 3 * TIMES * body, b.places, 3 * TIMES * other);
      }
      meanM += sum / TIMES;
      if (greatestM < greatest) greatestM = greatest;
    }
    if (this.bodies > 0) meanM /= this.bodies;
    return 0.5 * (meanM + greatestM) * (1 + this.orderBetween(a, b));
  }

  /** Distances between two bodies over the times: their sum and their maximum. */
  private apartOf(p: Float32Array, ofP: number, q: Float32Array, ofQ: number): readonly [number, number] {
    const apart = this.apart;
    for (let i = 0; i < TIMES; ++i) apart[i] = distanceM(p, ofP + i, q, ofQ + i);
    let greatest = apart[TIMES - 1]!;
    // Add four partial sums, by index modulo four, as the server's SIMD code does.
    let [s0, s1, s2, s3] = [0, 0, 0, 0];
    for (let i = 0; i + 4 <= TIMES; i += 4) {
      s0 += apart[i]!;
      s1 += apart[i + 1]!;
      s2 += apart[i + 2]!;
      s3 += apart[i + 3]!;
    }
    for (let i = 0; i < TIMES; ++i) if (greatest < apart[i]!) greatest = apart[i]!;
    return [s0 + s1 + (s2 + s3) + apart[TIMES - 1]!, greatest];
  }

  private match(a: Sketch, b: Sketch): void {
    for (const bodies of this.twins) {
      if (bodies.length === 1) {
        this.partnerOf[bodies[0]!] = bodies[0]!;
        continue;
      }
      let at = 0;
      for (const ofA of bodies) for (const ofB of bodies) this.costs[at++] = this.costOf(a, ofA, b, ofB);
      cheapestMatching(this.costs, bodies.length, this.columnOf);
      for (let i = 0; i < bodies.length; ++i) this.partnerOf[bodies[i]!] = bodies[this.columnOf[i]!]!;
    }
  }

  private costOf(a: Sketch, ofA: number, b: Sketch, ofB: number): number {
    if (a.enters[ofA] !== b.enters[ofB]) return this.apartM * this.apartM * MATCHING_TIMES;
    const p = a.matched;
    const q = b.matched;
    const end = 3 * MATCHING_TIMES * (ofA + 1);
    let cost = 0;
    for (let i = 3 * MATCHING_TIMES * ofA, j = 3 * MATCHING_TIMES * ofB; i < end; i += 3, j += 3) {
      const dx = p[i]! - q[j]!;
      const dy = p[i + 1]! - q[j + 1]!;
      const dz = p[i + 2]! - q[j + 2]!;
      cost += dx * dx + dy * dy + dz * dz;
    }
    return cost;
  }

  /** The share of first contacts that are not in the same order. */
  private orderBetween(a: Sketch, b: Sketch): number {
    const longer = Math.max(a.keys.length, b.keys.length);
    if (longer === 0) return 0;
    // Find the places of a's contacts in b's list. Contacts in a list are distinct, so the longest common
    // subsequence is the longest ascending subsequence of these places.
    let length = 0;
    for (let at = 0; at < a.contacts.length; at += 2) {
      const one = this.inB(a.contacts[at]!);
      const two = this.inB(a.contacts[at + 1]!);
      const key = two < one ? keyOf(two, one, this.features) : keyOf(one, two, this.features);
      const found = lowerBound(b.keys, b.keys.length, key);
      if (found < b.keys.length && b.keys[found] === key) length = withTail(b.placeOfKey[found]!, length);
    }
    return 1 - length / longer;
  }

  private inB(feature: number): number {
    return feature < this.bodies ? this.partnerOf[feature]! : feature;
  }
}

/** tails[n]: the smallest last value of an ascending subsequence of n + 1 values. */
const tails = new Uint32Array(FIRST_CONTACTS_MAX);

/** Adds a value; returns the length of the longest ascending subsequence. */
function withTail(value: number, length: number): number {
  const at = lowerBound(tails, length, value);
  tails[at] = value;
  return Math.max(length, at + 1);
}

function lowerBound(values: Float64Array | Uint32Array, count: number, value: number): number {
  let low = 0;
  let high = count;
  while (low < high) {
    const middle = (low + high) >>> 1;
    if (values[middle]! < value) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** Computed in single precision. */
function distanceM(a: Float32Array, p: number, b: Float32Array, q: number): number {
  const dx = Math.fround(a[p]! - b[q]!);
  const dy = Math.fround(a[p + TIMES]! - b[q + TIMES]!);
  const dz = Math.fround(a[p + 2 * TIMES]! - b[q + 2 * TIMES]!);
  const inPlane = Math.fround(Math.fround(dx * dx) + Math.fround(dy * dy));
  return Math.fround(Math.sqrt(Math.fround(inPlane + Math.fround(dz * dz))));
}
