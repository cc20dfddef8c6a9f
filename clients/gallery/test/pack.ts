// Packs answers as src/data/packed.ts describes.
import { ALIGNMENT, TYPES } from "../src/data/packed";
import type { Column } from "../src/data/types";

/** Returns bytes that unpack() reads. */
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

function typeOf(column: Column): string | undefined {
  return Object.entries(TYPES).find(([, type]) => column instanceof type)?.[0];
}
