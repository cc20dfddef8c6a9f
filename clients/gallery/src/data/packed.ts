// Packed answers: a JSON header and columns of numbers in one block of bytes.
//
//    Bytes: u32 H (little-endian), H bytes of JSON, columns.
//    JSON: {"head": {...}, "columns": [{"name":"start_s", "type":"f64", "offset":0, "count":12}, ...]}.
//
// Blanks pad the JSON, so that 4 + H is a multiple of 8. `offset` counts bytes from the end of the JSON and
// is a multiple of 8. `count` counts numbers, not rows. Columns are views of the answer's bytes, without
// copies. Truncated, misaligned or otherwise invalid answers throw.

import { SourceError } from "./source";
import type { Column } from "./types";

/** The result of unpack(). */
export interface Packed {
  readonly head: unknown;
  readonly columns: ReadonlyMap<string, Column>;
}

/** Column types by their name in the header. */
export const TYPES = {
  f64: Float64Array, f32: Float32Array, u32: Uint32Array, i32: Int32Array, u16: Uint16Array, u8: Uint8Array,
} as const;

type ColumnType = keyof typeof TYPES;

export const ALIGNMENT = 8;
/** Maximum size of the JSON header. */
const HEAD_BYTES_MAX = 64 * 1024 * 1024;

export function torn(what: string): SourceError {
  return new SourceError("torn", `invalid answer: ${what}`, "Reload the page.");
}

/** REQUIRES: a little-endian machine, as all browsers have. Throws SourceError("torn"). */
export function unpack(buffer: ArrayBuffer): Packed {
  if (buffer.byteLength < 4) throw torn("the header is missing");
  const headBytes = new DataView(buffer).getUint32(0, true);
  const start = 4 + headBytes;
  if (headBytes > HEAD_BYTES_MAX || start > buffer.byteLength) throw torn("the header is truncated");
  if (start % ALIGNMENT !== 0) throw torn("the header is not padded");
  const json = parsed(new Uint8Array(buffer, 4, headBytes));
  if (!isObject(json)) throw torn("the header is not an object");
  const descriptions = json["columns"];
  if (!Array.isArray(descriptions)) throw torn("'columns' is not a list");
  const columns = new Map<string, Column>();
  for (const description of descriptions) addColumn(columns, description, buffer, start);
  return { head: json["head"], columns };
}

export function isObject(value: unknown): value is Readonly<Record<string, unknown>> {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

function parsed(bytes: Uint8Array): unknown {
  try {
    return JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(bytes));
  } catch {
    throw torn("the header is not JSON");
  }
}

function addColumn(
  columns: Map<string, Column>, description: unknown, buffer: ArrayBuffer, start: number,
): void {
  if (!isObject(description)) throw torn("a column's description is not an object");
  const { name, type, offset, count } = description;
  if (typeof name !== "string" || !isType(type) || !isCount(offset) || !isCount(count))
    throw torn("a column's description is invalid");
  if (columns.has(name)) throw torn(`two columns have the name '${name}'`);
  if (offset % ALIGNMENT !== 0) throw torn(`column '${name}' is not aligned`);
  if (start + offset + count * TYPES[type].BYTES_PER_ELEMENT > buffer.byteLength) throw torn(`column '${name}' is truncated`);
  columns.set(name, new TYPES[type](buffer, start + offset, count));
}

function isType(value: unknown): value is ColumnType {
  return typeof value === "string" && Object.hasOwn(TYPES, value);
}

function isCount(value: unknown): value is number {
  return typeof value === "number" && Number.isSafeInteger(value) && value >= 0;
}
