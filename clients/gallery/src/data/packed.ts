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

type ColumnType = "f64" | "f32" | "u32" | "i32" | "u16" | "u8";

const BYTES: Readonly<Record<ColumnType, number>> = { f64: 8, f32: 4, u32: 4, i32: 4, u16: 2, u8: 1 };
const ALIGNMENT = 8;
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

/** Returns bytes that unpack() reads; for tests and for programs that write answers. */
export function pack(head: unknown, columns: ReadonlyMap<string, Column>): Uint8Array {
  const list: object[] = [];
  let size = 0;
  for (const [name, column] of columns) {
    list.push({ name, type: typeOf(column), offset: size, count: column.length });
    size += Math.ceil(column.byteLength / ALIGNMENT) * ALIGNMENT;
  }
  const text = new TextEncoder().encode(JSON.stringify({ head, columns: list }));
  const start = Math.ceil((4 + text.length) / ALIGNMENT) * ALIGNMENT;
  const bytes = new Uint8Array(start + size);
  new DataView(bytes.buffer).setUint32(0, start - 4, true);
  bytes.fill(0x20, 4, start);
  bytes.set(text, 4);
  let at = start;
  for (const column of columns.values()) {
    bytes.set(new Uint8Array(column.buffer, column.byteOffset, column.byteLength), at);
    at += Math.ceil(column.byteLength / ALIGNMENT) * ALIGNMENT;
  }
  return bytes;
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
  if (start + offset + count * BYTES[type] > buffer.byteLength) throw torn(`column '${name}' is truncated`);
  columns.set(name, columnOf(type, buffer, start + offset, count));
}

function columnOf(type: ColumnType, buffer: ArrayBuffer, at: number, count: number): Column {
  switch (type) {
    case "f64": return new Float64Array(buffer, at, count);
    case "f32": return new Float32Array(buffer, at, count);
    case "u32": return new Uint32Array(buffer, at, count);
    case "i32": return new Int32Array(buffer, at, count);
    case "u16": return new Uint16Array(buffer, at, count);
    case "u8": return new Uint8Array(buffer, at, count);
  }
}

function typeOf(column: Column): ColumnType {
  if (column instanceof Float64Array) return "f64";
  if (column instanceof Float32Array) return "f32";
  if (column instanceof Uint32Array) return "u32";
  if (column instanceof Int32Array) return "i32";
  return column instanceof Uint16Array ? "u16" : "u8";
}

function isType(value: unknown): value is ColumnType {
  return typeof value === "string" && Object.hasOwn(BYTES, value);
}

function isCount(value: unknown): value is number {
  return typeof value === "number" && Number.isSafeInteger(value) && value >= 0;
}
