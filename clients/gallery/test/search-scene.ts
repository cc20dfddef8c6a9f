// Made-up animations for the tests of the search, in the scene of tests/unit/clients/browse/random_index.h:
// two twin balls, one other ball, a table, a wall and a goal.
import { unpack } from "../src/data/packed";
import { pack } from "./pack";
import type { Column } from "../src/data/types";
import { readIndex, type SearchIndex } from "../src/search/search-index";
import { Turns } from "../src/search/turns";

export type Triple = readonly [number, number, number];

export interface MadePiece {
  readonly start: number;
  readonly p: Triple;
  readonly v?: Triple;
  readonly a?: Triple;
}

export interface MadeEntry {
  readonly draw: number;
  readonly isFind?: boolean;
  readonly end: number;
  /** Paths by body; empty: the body never enters. */
  readonly paths: readonly (readonly MadePiece[])[];
  /** Time, body and partner, in the order of time. */
  readonly contacts: readonly Triple[];
  /** In the order of NUMBERS. */
  readonly numbers: readonly number[];
}

export const FEATURES = [
  { name: "ball 1", kind: "body", twin_of: 0 }, { name: "ball 2", kind: "body", twin_of: 0 },
  { name: "odd \"one\"", kind: "body", twin_of: 2 }, { name: "table", kind: "fixed", twin_of: 3 },
  { name: "west wall", kind: "fixed", twin_of: 4 }, { name: "target", kind: "wanted", twin_of: 5 },
] as const;
export const BODIES = 3;
export const NUMBERS = [
  { name: "log_prior", unit: "1" }, { name: "rest_s", unit: "s" }, { name: "landing_m", unit: "m" },
  { name: "face[0]", unit: "1" }, { name: "face[1]", unit: "1" }, { name: "turn", unit: "rad" },
] as const;

/** The bytes of an index file with these animations. */
export function indexBytes(entries: readonly MadeEntry[]): Uint8Array {
  const tracks = entries.flatMap((entry) => entry.paths);
  const pieces = tracks.flat();
  const contacts = entries.flatMap((entry) => entry.contacts);
  const none: Triple = [0, 0, 0];
  let first = 0;
  const firsts = tracks.map((path) => (first += path.length) - path.length);
  let contact = 0;
  const f64 = (values: readonly number[]): Float64Array => Float64Array.from(values);
  const u32 = (values: readonly number[]): Uint32Array => Uint32Array.from(values);
  const columns = new Map<string, Column>([
    ["is_find", Uint8Array.from(entries, (entry) => entry.isFind ? 1 : 0)],
    ["chain", new Uint32Array(entries.length)],
    ["draw", f64(entries.map((entry) => entry.draw))],
    ["end_s", f64(entries.map((entry) => entry.end))],
    ...NUMBERS.map((_, k): [string, Column] =>
      [`number.${k}`, f64(entries.map((entry) => entry.numbers[k]!))]),
    ["track_first", u32(firsts)],
    ["track_count", u32(tracks.map((path) => path.length))],
    ["piece_start_s", f64(pieces.map((piece) => piece.start))],
    ["piece_position_m", f64(pieces.flatMap((piece) => piece.p))],
    ["piece_velocity_mps", f64(pieces.flatMap((piece) => piece.v ?? none))],
    // The program stores each acceleration once; a row for each piece is equally valid.
    ["piece_acceleration", u32([...pieces.keys()])],
    ["accelerations_mps2", f64(pieces.flatMap((piece) => piece.a ?? none))],
    ["contact_first", u32([0, ...entries.map((entry) => (contact += entry.contacts.length))])],
    ["contact_time_s", f64(contacts.map(([time]) => time))],
    ["contact_body", u32(contacts.map(([, body]) => body))],
    ["contact_partner", u32(contacts.map(([, , partner]) => partner))],
  ]);
  const names = entries.map((entry) => entry.isFind ? `find.${entry.draw}` : `0.${entry.draw}`);
  const head = {
    generation: 7, run: "run", entries: entries.length, bodies: BODIES, names, features: FEATURES,
    numbers: NUMBERS, view_low_m: [-1, -1, 0], view_high_m: [1, 1, 1],
  };
  return pack(head, columns);
}

export function indexOf(entries: readonly MadeEntry[]): Promise<SearchIndex> {
  return readIndex(unpack(indexBytes(entries).buffer as ArrayBuffer), new Turns());
}

/** Uniform in [0, 1), by mulberry32, so that a test's cases are the same everywhere. */
export function randomNumbers(seed: number): () => number {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let bits = Math.imul(state ^ (state >>> 15), state | 1);
    bits ^= bits + Math.imul(bits ^ (bits >>> 7), bits | 61);
    return ((bits ^ (bits >>> 14)) >>> 0) / 2 ** 32;
  };
}

/** Pieces as in recordings: parabolas, straight lines and rests. Some start where the previous piece ended,
 *  others elsewhere. A body enters late or never. */
export function randomEntry(draw: number, random: () => number): MadeEntry {
  const between = (low: number, high: number): number => low + (high - low) * random();
  const vector = (size: number): Triple => [between(-size, size), between(-size, size), between(-size, size)];
  const paths: MadePiece[][] = [];
  const contacts: Triple[] = [];
  let end = 0;
  for (let body = 0; body < BODIES; ++body) {
    const path: MadePiece[] = [];
    const count = body > 0 && random() < 0.1 ? 0 : 1 + Math.floor(6 * random());
    let start = body === 0 ? 0 : between(0, 0.3);
    let place = vector(1);
    for (let i = 0; i < count; ++i) {
      const isLast = i + 1 === count;
      const v: Triple = isLast ? [0, 0, 0] : vector(2);
      const a: Triple = isLast || random() < 0.3 ? [0, 0, 0] : random() < 0.2 ? vector(3) : [0, 0, -9.81];
      path.push({ start, p: place, v, a });
      if (i > 0) contacts.push([start, body, (body + 1 + Math.floor(4 * random())) % 5]);
      if (isLast) end = Math.max(end, start);
      const s = random() < 0.1 ? 0 : between(0, 0.4);
      const moved = (axis: 0 | 1 | 2): number => place[axis] + s * v[axis] + 0.5 * s * s * a[axis];
      place = random() < 0.1 ? vector(1) : [moved(0), moved(1), moved(2)];
      start += s;
    }
    paths.push(path);
  }
  contacts.sort((a, b) => a[0] - b[0] || a[1] - b[1] || a[2] - b[2]);
  const numbers = [between(-20, 0), end, draw % 5 === 0 ? NaN : between(-1, 1), 1, 2, between(-3, 3)];
  return { draw, end, paths, contacts, numbers };
}
