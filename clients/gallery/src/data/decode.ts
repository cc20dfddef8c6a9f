// From answers, which are JSON or packed bytes of whoever answered, to the page's types.
//
// Everything that is used later is checked here, so that a wrong answer is one sentence instead of a
// failure somewhere in the page. Functions throw SourceError("torn").

import { Recording } from "../motion/recording";
import type { Segments } from "../motion/segments";
import { isObject, type Packed, torn } from "./packed";
import type {
  Animation, Column, Feature, GalleryState, Looks, Mesh, Place, Scene, Series, SeriesTitle, Table,
} from "./types";

type Json = Readonly<Record<string, unknown>>;

function objectOf(value: unknown, what: string): Json {
  if (!isObject(value)) throw torn(`${what} is no object`);
  return value;
}

function listOf(value: unknown, what: string): readonly unknown[] {
  if (!Array.isArray(value)) throw torn(`${what} is no list`);
  return value;
}

function numberOf(value: unknown, what: string): number {
  if (typeof value !== "number") throw torn(`${what} is no number`);
  return value;
}

function textOf(value: unknown, what: string): string {
  if (typeof value !== "string") throw torn(`${what} is no text`);
  return value;
}

function indexOf(value: unknown, what: string): number {
  const index = numberOf(value, what);
  if (!Number.isSafeInteger(index) || index < 0) throw torn(`${what} is no index`);
  return index;
}

function placeOf(value: unknown, what: string): Place {
  const [x, y, z] = listOf(value, what);
  return [numberOf(x, what), numberOf(y, what), numberOf(z, what)];
}

/** The gallery's state; of its archives what the page relies on is checked. */
export function galleryOf(value: unknown): GalleryState {
  const state = objectOf(value, "the gallery");
  for (const archive of listOf(state["archives"], "the list of archives")) {
    const of = objectOf(archive, "an archive");
    indexOf(of["id"], "an archive's number");
    numberOf(of["generation"], "a generation");
    textOf(of["run"], "a run");
    textOf(of["name"], "an archive's name");
    textOf(of["state"], "an archive's state");
  }
  listOf(state["left_out"], "what was left out");
  objectOf(state["notes"], "what is said of notes");
  return value as GalleryState;
}

export function sceneOf(value: unknown): Scene {
  const scene = objectOf(value, "a scene");
  let bodiesEnd = false;
  const features = listOf(scene["features"], "the list of features").map((item): Feature => {
    const feature = objectOf(item, "a feature");
    const kind = textOf(feature["kind"], "a feature's kind");
    if (kind !== "body" && kind !== "fixed" && kind !== "wanted") throw torn(`'${kind}' is no kind`);
    if (kind === "body" && bodiesEnd) throw torn("bodies don't come first");
    bodiesEnd ||= kind !== "body";
    return {
      name: textOf(feature["name"], "a feature's name"),
      kind,
      twin_of: numberOf(feature["twin_of"], "a twin"),
      body: numberOf(feature["body"], "a feature's body"),
      radius_m: numberOf(feature["radius_m"], "a radius"),
    };
  });
  return {
    generation: numberOf(scene["generation"], "a generation"),
    view_low_m: placeOf(scene["view_low_m"], "the view"),
    view_high_m: placeOf(scene["view_high_m"], "the view"),
    offsets: scene["offsets"] === true,
    features,
    numbers: listOf(scene["numbers"], "the list of numbers").map((item) => {
      const of = objectOf(item, "a number's title");
      return { name: textOf(of["name"], "a number's name"), unit: textOf(of["unit"], "a unit") };
    }),
    prior_log_prior: listOf(scene["prior_log_prior"] ?? [], "blind throws").map((item) =>
      numberOf(item, "a blind throw's number")),
    request: textOf(scene["request"], "the request"),
  };
}

export function looksOf(packed: Packed): Looks {
  const head = objectOf(packed.head, "what things look like");
  return {
    generation: numberOf(head["generation"], "a generation"),
    meshes: meshesOf(head["meshes"], packed.columns),
    own: listOf(head["own"] ?? [], "the list of own looks").map((item) => indexOf(item, "a feature")),
  };
}

export function tableOf(packed: Packed): Table {
  const head = objectOf(packed.head, "a table");
  const entries = indexOf(head["entries"], "the number of entries");
  const { columns } = packed;
  const numbers = new Map<string, Float64Array>();
  listOf(head["numbers"], "the list of numbers").forEach((name, k) => {
    numbers.set(textOf(name, "a number's name"), f64(columns, `number.${k}`, entries));
  });
  return {
    generation: numberOf(head["generation"], "a generation"),
    entries,
    isFind: u8(columns, "is_find", entries),
    chain: u32(columns, "chain", entries),
    draw: f64(columns, "draw", entries),
    inProportion: u8(columns, "in_proportion", entries),
    endS: f64(columns, "end_s", entries),
    lineage: f64(columns, "lineage", entries),
    numbers,
  };
}

/** Of an answer to `names=`; in the answer's order. */
export function animationsOf(packed: Packed, bodies: number): Animation[] {
  const head = objectOf(packed.head, "animations");
  return listOf(head["animations"], "the list of animations").map((item) => {
    const of = objectOf(item, "an animation");
    return animationOf(of, packed.columns, textOf(of["columns"], "a prefix"), bodies);
  });
}

function animationOf(
  head: Json, columns: ReadonlyMap<string, Column>, prefix: string, bodies: number,
): Animation {
  const name = textOf(head["name"], "an animation's name");
  const figures: Record<string, number> = {};
  for (const [key, value] of Object.entries(isObject(head["figures"]) ? head["figures"] : {}))
    if (typeof value === "number") figures[key] = value;
  let recording: Recording;
  try {
    recording = new Recording(segmentsOf(columns, prefix), bodies);
  } catch (error) {
    if (error instanceof Error && error.name === "SourceError") throw error;
    throw torn(`animation ${name}: ${error instanceof Error ? error.message : ""}`);
  }
  return {
    name,
    endS: numberOf(head["end_s"], "an animation's end"),
    recording,
    meshes: meshesOf(head["meshes"] ?? [], columns),
    figures,
  };
}

/** `prefix` stands before each column's name. */
export function segmentsOf(columns: ReadonlyMap<string, Column>, prefix: string): Segments {
  const body = columns.get(`${prefix}body`);
  if (!(body instanceof Uint32Array)) throw torn("an animation has no column 'body'");
  const count = body.length;
  return {
    count,
    body,
    startS: f64(columns, `${prefix}start_s`, count),
    mode: u8(columns, `${prefix}mode`, count),
    cause: u8(columns, `${prefix}cause`, count),
    partner: i32(columns, `${prefix}partner`, count),
    position: f64(columns, `${prefix}position_m`, 3 * count),
    velocity: f64(columns, `${prefix}velocity_mps`, 3 * count),
    acceleration: f64(columns, `${prefix}acceleration_mps2`, 3 * count),
    orientation: f64(columns, `${prefix}orientation`, 4 * count),
    angularVelocity: f64(columns, `${prefix}angular_velocity_radps`, 3 * count),
    angularAcceleration: f64(columns, `${prefix}angular_acceleration_radps2`, 3 * count),
  };
}

function meshesOf(value: unknown, columns: ReadonlyMap<string, Column>): Mesh[] {
  return listOf(value, "the list of meshes").map((item): Mesh => {
    const mesh = objectOf(item, "a mesh");
    const column = (key: string): Column | undefined => columns.get(textOf(mesh[key], "a column"));
    const places = column("places");
    const normals = column("normals");
    const corners = column("corners");
    if (!(places instanceof Float32Array) || !(normals instanceof Float32Array) ||
        !(corners instanceof Uint32Array))
      throw torn("a mesh lacks a column");
    if (places.length % 3 !== 0 || normals.length !== places.length || corners.length % 3 !== 0)
      throw torn("a mesh's columns don't fit one another");
    const vertices = places.length / 3;
    for (const corner of corners) if (corner >= vertices) throw torn("a mesh names a vertex it lacks");
    const colour = textOf(mesh["colour"], "a colour");
    if (!/^#[0-9a-f]{6}$/i.test(colour)) throw torn("a colour has another form");
    return {
      feature: indexOf(mesh["feature"], "a mesh's feature"),
      colour,
      opacity: numberOf(mesh["opacity"] ?? 1, "an opacity"),
      doubleSided: mesh["double_sided"] === true,
      places,
      normals,
      corners,
    };
  });
}

export function seriesTitlesOf(value: unknown): SeriesTitle[] {
  return listOf(value, "the list of plots").map((item) => {
    const of = objectOf(item, "a plot");
    return {
      ...of,
      name: textOf(of["name"], "a plot's name"),
      title: textOf(of["title"], "a plot's title"),
      kind: textOf(of["kind"], "a plot's kind"),
      group: textOf(of["group"], "a plot's group"),
    };
  });
}

export function seriesOf(packed: Packed): Series {
  return { head: packed.head, columns: packed.columns };
}

function column(columns: ReadonlyMap<string, Column>, name: string, count: number): Column {
  const found = columns.get(name);
  if (found === undefined) throw torn(`it has no column '${name}'`);
  if (found.length !== count) throw torn(`column '${name}' has ${found.length} numbers instead of ${count}`);
  return found;
}

function f64(columns: ReadonlyMap<string, Column>, name: string, count: number): Float64Array {
  const found = column(columns, name, count);
  if (!(found instanceof Float64Array)) throw torn(`column '${name}' isn't f64`);
  return found;
}

function u32(columns: ReadonlyMap<string, Column>, name: string, count: number): Uint32Array {
  const found = column(columns, name, count);
  if (!(found instanceof Uint32Array)) throw torn(`column '${name}' isn't u32`);
  return found;
}

function i32(columns: ReadonlyMap<string, Column>, name: string, count: number): Int32Array {
  const found = column(columns, name, count);
  if (!(found instanceof Int32Array)) throw torn(`column '${name}' isn't i32`);
  return found;
}

function u8(columns: ReadonlyMap<string, Column>, name: string, count: number): Uint8Array {
  const found = column(columns, name, count);
  if (!(found instanceof Uint8Array)) throw torn(`column '${name}' isn't u8`);
  return found;
}
