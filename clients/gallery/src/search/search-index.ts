// The index of an archive for searching and comparing: columns of paths, contacts and numbers.
//
// Columns stay views of the file's bytes: a large archive has millions of pieces, and an object for each
// would take too much memory. clients/gallery_server/index_columns.h describes the file.

import { isObject, type Packed, torn } from "../data/packed";
import type { Place } from "../data/types";
import { measureReach, type Reach } from "./reach";
import type { Turns } from "./turns";

/** Rows between two checks of the clock. */
const CHECKED_AT_ONCE = 65_536;

export interface IndexFeature {
  readonly name: string;
  readonly kind: "body" | "fixed" | "wanted";
  /** The first of the interchangeable bodies; the body itself if it isn't interchangeable. */
  readonly twin_of: number;
}

/** A box around all motion: the scene's view_low_m and view_high_m. */
export interface View {
  readonly view_low_m: Place;
  readonly view_high_m: Place;
}

/** Columns by animation, by piece of path and by contact, for n animations of b bodies. */
export interface Columns {
  readonly isFind: Uint8Array;
  readonly chain: Uint32Array;
  readonly draw: Float64Array;
  /** Time when the last body comes to rest. */
  readonly endS: Float64Array;
  /** In the order of the header's numbers. */
  readonly numbers: readonly Float64Array[];
  /** Row i b + k: the pieces of body k of animation i, in the order of time. */
  readonly trackFirst: Uint32Array;
  readonly trackCount: Uint32Array;
  /** A piece is position + velocity s + acceleration s^2 / 2, with s counted from the piece's start. */
  readonly startS: Float64Array;
  readonly positionM: Float64Array;
  readonly velocityMps: Float64Array;
  /** Rows of accelerationsMps2. */
  readonly acceleration: Uint32Array;
  readonly accelerationsMps2: Float64Array;
  /** Contacts of animation i are rows [i] to [i + 1] - 1, in the order of (time, body, partner). */
  readonly contactFirst: Uint32Array;
  readonly contactTimeS: Float64Array;
  readonly contactBody: Uint32Array;
  readonly contactPartner: Uint32Array;
}

export interface SearchIndex extends Columns {
  readonly generation: number;
  readonly run: string;
  /** Names of animations, such as "c0.250" or "find.3". */
  readonly names: readonly string[];
  readonly entries: number;
  readonly bodies: number;
  readonly features: readonly IndexFeature[];
  readonly numberNames: readonly { readonly name: string; readonly unit: string }[];
  readonly view: View;
  readonly reach: Reach;
}

/** Throws SourceError. */
export async function readIndex(packed: Packed, turns: Turns): Promise<SearchIndex> {
  const head = packed.head;
  if (!isObject(head)) throw torn("the index's header is not an object");
  const { generation, run, names, entries, bodies, features, numbers } = head;
  if (!isCount(generation) || typeof run !== "string" || !isCount(entries) || !isCount(bodies))
    throw torn("the index's header is invalid");
  if (!isListOf(names, isText) || names.length !== entries) throw torn("the index's names are missing");
  if (!isListOf(features, isFeature)) throw torn("the index's features are missing");
  if (!isView(head)) throw torn("the index's view is missing");
  if (!isListOf(numbers, isNumberName)) throw torn("the index's numbers are missing");
  const firstThing = features.findIndex((feature) => feature.kind !== "body");
  if ((firstThing < 0 ? features.length : firstThing) !== bodies) throw torn("the index has a wrong number of bodies");
  const columns = columnsOf(packed, entries, bodies, numbers.length);
  await check(columns, bodies, features.length, turns);
  return {
    ...columns, generation, run, names, entries, bodies, features,
    numberNames: numbers,
    view: head,
    reach: await measureReach(columns, turns),
  };
}

function columnsOf(packed: Packed, entries: number, bodies: number, numbers: number): Columns {
  const f64 = (name: string, count?: number): Float64Array => column(packed, name, Float64Array, count);
  const u32 = (name: string, count?: number): Uint32Array => column(packed, name, Uint32Array, count);
  const startS = f64("piece_start_s");
  const contactTimeS = f64("contact_time_s");
  return {
    isFind: column(packed, "is_find", Uint8Array, entries),
    chain: u32("chain", entries),
    draw: f64("draw", entries),
    endS: f64("end_s", entries),
    numbers: Array.from({ length: numbers }, (_, number) => f64(`number.${number}`, entries)),
    trackFirst: u32("track_first", entries * bodies),
    trackCount: u32("track_count", entries * bodies),
    startS,
    positionM: f64("piece_position_m", 3 * startS.length),
    velocityMps: f64("piece_velocity_mps", 3 * startS.length),
    acceleration: u32("piece_acceleration", startS.length),
    accelerationsMps2: f64("accelerations_mps2"),
    contactFirst: u32("contact_first", entries + 1),
    contactTimeS,
    contactBody: u32("contact_body", contactTimeS.length),
    contactPartner: u32("contact_partner", contactTimeS.length),
  };
}

/** Checks row numbers, because wrong ones would cause NaN much later. */
async function check(columns: Columns, bodies: number, features: number, turns: Turns): Promise<void> {
  const { trackFirst, trackCount, contactFirst } = columns;
  const pieces = columns.startS.length;
  const contacts = columns.contactTimeS.length;
  for (let track = 0; track < trackFirst.length; ++track)
    if (trackFirst[track]! + trackCount[track]! > pieces) throw torn("a track refers to missing pieces");
  for (let entry = 1; entry < contactFirst.length; ++entry)
    if (contactFirst[entry]! < contactFirst[entry - 1]!) throw torn("a contact belongs to no animation");
  if (contactFirst[contactFirst.length - 1] !== contacts) throw torn("a contact belongs to no animation");
  await checkRows(columns.acceleration, columns.accelerationsMps2.length / 3, turns);
  await checkRows(columns.contactBody, bodies, turns);
  await checkRows(columns.contactPartner, features, turns);
}

async function checkRows(rows: Uint32Array, count: number, turns: Turns): Promise<void> {
  for (let at = 0; at < rows.length; ++at) {
    if (rows[at]! >= count) throw torn("the index refers to a missing row");
    if (at % CHECKED_AT_ONCE === 0 && turns.isDue()) await turns.take();
  }
}

interface ColumnClass<T> {
  readonly name: string;
  new(count: number): T;
}

function column<T extends { readonly length: number }>(
  packed: Packed, name: string, type: ColumnClass<T>, count?: number,
): T {
  const found: unknown = packed.columns.get(name);
  if (!(found instanceof type)) throw torn(`column '${name}' of ${type.name} is missing`);
  if (count !== undefined && found.length !== count) throw torn(`column '${name}' has a wrong length`);
  return found;
}

function isListOf<T>(value: unknown, isOne: (one: unknown) => one is T): value is T[] {
  return Array.isArray(value) && value.every(isOne);
}
function isCount(value: unknown): value is number {
  return typeof value === "number" && Number.isSafeInteger(value) && value >= 0;
}
function isText(value: unknown): value is string {
  return typeof value === "string";
}
function isNumberName(value: unknown): value is { name: string; unit: string } {
  return isObject(value) && isText(value["name"]) && isText(value["unit"]);
}
function isFeature(value: unknown): value is IndexFeature {
  return isObject(value) && isText(value["name"]) && isCount(value["twin_of"]) &&
    (value["kind"] === "body" || value["kind"] === "fixed" || value["kind"] === "wanted");
}
function isView(value: unknown): value is View {
  return isObject(value) && isPlace(value["view_low_m"]) && isPlace(value["view_high_m"]);
}
function isPlace(value: unknown): value is Place {
  return Array.isArray(value) && value.length === 3 && value.every((one) => typeof one === "number");
}
