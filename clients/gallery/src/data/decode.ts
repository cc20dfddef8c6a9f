// Decodes answers (JSON or packed bytes from any server) into the page's types.
//
// All values that the page uses are checked here, so an invalid answer becomes one error message instead of a
// failure elsewhere. Functions throw SourceError("torn").

import { Recording } from "../motion/recording";
import type { Segments } from "../motion/segments";
import { isObject, type Packed, torn } from "./packed";
import type {
  Animation, Column, Feature, GalleryState, Looks, Mesh, Place, Scene, Series, SeriesTitle, Table,
} from "./types";

type Json = Readonly<Record<string, unknown>>;

function objectOf(value: unknown, what: string): Json {
  if (!isObject(value)) throw torn(`${what} is not an object`);
  return value;
}

function listOf(value: unknown, what: string): readonly unknown[] {
  if (!Array.isArray(value)) throw torn(`${what} is not a list`);
  return value;
}

function numberOf(value: unknown, what: string): number {
  if (typeof value !== "number") throw torn(`${what} is not a number`);
  return value;
}

function textOf(value: unknown, what: string): string {
  if (typeof value !== "string") throw torn(`${what} is not a string`);
  return value;
}

function indexOf(value: unknown, what: string): number {
  const index = numberOf(value, what);
  if (!Number.isSafeInteger(index) || index < 0) throw torn(`${what} is not an index`);
  return index;
}

function placeOf(value: unknown, what: string): Place {
  const [x, y, z] = listOf(value, what);
  return [numberOf(x, what), numberOf(y, what), numberOf(z, what)];
}

/** Decodes the gallery's state, and checks the archives' fields that the page relies on. */
export function galleryOf(value: unknown): GalleryState {
  const state = objectOf(value, "the gallery");
  for (const archive of listOf(state["archives"], "'archives'")) {
    const of = objectOf(archive, "an archive");
    indexOf(of["id"], "an archive's id");
    numberOf(of["generation"], "an archive's generation");
    textOf(of["run"], "an archive's run");
    textOf(of["name"], "an archive's name");
    textOf(of["state"], "an archive's state");
  }
  listOf(state["left_out"], "'left_out'");
  objectOf(state["notes"], "'notes'");
  return value as GalleryState;
}

export function sceneOf(value: unknown): Scene {
  const scene = objectOf(value, "a scene");
  let bodiesEnd = false;
  const features = listOf(scene["features"], "'features'").map((item): Feature => {
    const feature = objectOf(item, "a feature");
    const kind = textOf(feature["kind"], "a feature's kind");
    if (kind !== "body" && kind !== "fixed" && kind !== "wanted") throw torn(`'${kind}' is not a kind of feature`);
    if (kind === "body" && bodiesEnd) throw torn("a body follows another feature");
    bodiesEnd ||= kind !== "body";
    return {
      name: textOf(feature["name"], "a feature's name"),
      kind,
      radius_m: numberOf(feature["radius_m"], "a feature's radius"),
    };
  });
  return {
    view_low_m: placeOf(scene["view_low_m"], "'view_low_m'"),
    view_high_m: placeOf(scene["view_high_m"], "'view_high_m'"),
    features,
    numbers: listOf(scene["numbers"], "'numbers'").map((item) => {
      const of = objectOf(item, "an entry of 'numbers'");
      return { name: textOf(of["name"], "a number's name"), unit: textOf(of["unit"], "a unit") };
    }),
    prior_log_prior: listOf(scene["prior_log_prior"] ?? [], "'prior_log_prior'").map((item) =>
      numberOf(item, "an entry of 'prior_log_prior'")),
  };
}

export function looksOf(packed: Packed): Looks {
  const head = objectOf(packed.head, "the header of looks");
  return { meshes: meshesOf(head["meshes"], packed.columns) };
}

export function tableOf(packed: Packed): Table {
  const head = objectOf(packed.head, "a table's header");
  const entries = indexOf(head["entries"], "the number of entries");
  const { columns } = packed;
  const numbers = new Map<string, Float64Array>();
  listOf(head["numbers"], "'numbers'").forEach((name, k) => {
    numbers.set(textOf(name, "a number's name"), typed(columns, `number.${k}`, entries, Float64Array));
  });
  return {
    generation: numberOf(head["generation"], "a table's generation"),
    entries,
    isFind: typed(columns, "is_find", entries, Uint8Array),
    chain: typed(columns, "chain", entries, Uint32Array),
    draw: typed(columns, "draw", entries, Float64Array),
    inProportion: typed(columns, "in_proportion", entries, Uint8Array),
    numbers,
  };
}

/** Decodes an answer to `names=`, in the answer's order. */
export function animationsOf(packed: Packed, bodies: number): Animation[] {
  const head = objectOf(packed.head, "the header of animations");
  return listOf(head["animations"], "'animations'").map((item) => {
    const of = objectOf(item, "an animation");
    return animationOf(of, packed.columns, textOf(of["columns"], "an animation's column prefix"), bodies);
  });
}

function animationOf(
  head: Json, columns: ReadonlyMap<string, Column>, prefix: string, bodies: number,
): Animation {
  const name = textOf(head["name"], "an animation's name");
  let recording: Recording;
  try {
    recording = new Recording(segmentsOf(columns, prefix), bodies);
  } catch (error) {
    if (error instanceof Error && error.name === "SourceError") throw error;
    throw torn(`animation ${name}: ${error instanceof Error ? error.message : ""}`);
  }
  return { name, recording, meshes: meshesOf(head["meshes"] ?? [], columns) };
}

/** `prefix` precedes each column's name. */
export function segmentsOf(columns: ReadonlyMap<string, Column>, prefix: string): Segments {
  const body = columns.get(`${prefix}body`);
  if (!(body instanceof Uint32Array)) throw torn("an animation has no column 'body'");
  const count = body.length;
  return {
    count,
    body,
    startS: typed(columns, `${prefix}start_s`, count, Float64Array),
    mode: typed(columns, `${prefix}mode`, count, Uint8Array),
    cause: typed(columns, `${prefix}cause`, count, Uint8Array),
    partner: typed(columns, `${prefix}partner`, count, Int32Array),
    position: typed(columns, `${prefix}position_m`, 3 * count, Float64Array),
    velocity: typed(columns, `${prefix}velocity_mps`, 3 * count, Float64Array),
    acceleration: typed(columns, `${prefix}acceleration_mps2`, 3 * count, Float64Array),
    orientation: typed(columns, `${prefix}orientation`, 4 * count, Float64Array),
    angularVelocity: typed(columns, `${prefix}angular_velocity_radps`, 3 * count, Float64Array),
    angularAcceleration: typed(columns, `${prefix}angular_acceleration_radps2`, 3 * count, Float64Array),
  };
}

function meshesOf(value: unknown, columns: ReadonlyMap<string, Column>): Mesh[] {
  return listOf(value, "'meshes'").map((item): Mesh => {
    const mesh = objectOf(item, "a mesh");
    const column = (key: string): Column | undefined => columns.get(textOf(mesh[key], "a mesh's column"));
    const places = column("places");
    const normals = column("normals");
    const corners = column("corners");
    if (!(places instanceof Float32Array) || !(normals instanceof Float32Array) ||
        !(corners instanceof Uint32Array))
      throw torn("a column of a mesh is missing");
    if (places.length % 3 !== 0 || normals.length !== places.length || corners.length % 3 !== 0)
      throw torn("a mesh's columns differ in length");
    const vertices = places.length / 3;
    for (const corner of corners) if (corner >= vertices) throw torn("a mesh refers to a missing vertex");
    const colour = textOf(mesh["colour"], "a mesh's colour");
    if (!/^#[0-9a-f]{6}$/i.test(colour)) throw torn("a mesh's colour does not have the form #rrggbb");
    return {
      feature: indexOf(mesh["feature"], "a mesh's feature"),
      colour,
      opacity: numberOf(mesh["opacity"] ?? 1, "a mesh's opacity"),
      doubleSided: mesh["double_sided"] === true,
      places,
      normals,
      corners,
    };
  });
}

export function seriesTitlesOf(value: unknown): SeriesTitle[] {
  return listOf(value, "the plots").map((item) => {
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

/** The column `name`. REQUIRES: it has `count` numbers of this type. */
function typed<C extends Column>(
  columns: ReadonlyMap<string, Column>, name: string, count: number, type: new (...of: never[]) => C,
): C {
  const found = columns.get(name);
  if (found === undefined) throw torn(`column '${name}' is missing`);
  if (found.length !== count) throw torn(`column '${name}' has ${found.length} values instead of ${count}`);
  if (!(found instanceof type)) throw torn(`column '${name}' is no ${type.name}`);
  return found;
}
