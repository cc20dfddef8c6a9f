// Decodes a saved gallery's binary files: base64 of gzip data.
//
// Files are decoded in parts, to limit memory and to keep the page responsive.

import { Turns } from "../search/turns";
import { torn } from "./packed";
import { SourceError } from "./source";

/** Characters per part; a multiple of four, because four characters encode three bytes. */
const PART = 1 << 18;
/** Deflate's maximum compression ratio: a file that claims a larger one is invalid. */
const RATIO_MAX = 1032;
/** Characters that contain gzip's trailer: checksum and size, four bytes each. */
const TRAILER_CHARACTERS = 8;

/** Throws SourceError("torn"), or "other" if the browser lacks DecompressionStream. */
export async function unzipped(base64: string): Promise<ArrayBuffer> {
  if (typeof DecompressionStream === "undefined")
    throw new SourceError("other", "This browser is too old to read animations.", "Use a newer browser.");
  try {
    return await inflated(base64);
  } catch (error) {
    if (error instanceof SourceError) throw error;
    throw torn("the file is damaged");
  }
}

async function inflated(base64: string): Promise<ArrayBuffer> {
  const bytes = new Uint8Array(sizeOf(base64));
  let filled = 0;
  const turns = new Turns();
  const reader = partsOf(base64).pipeThrough(new DecompressionStream("gzip")).getReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    // set() throws if there are more bytes than the trailer declares.
    bytes.set(value, filled);
    filled += value.length;
    if (turns.isDue()) await turns.take();
  }
  if (filled !== bytes.length) throw torn("the file is truncated");
  return bytes.buffer;
}

/** The size of the unzipped bytes, from gzip's trailer. */
function sizeOf(base64: string): number {
  const end = decoded(base64.slice(-TRAILER_CHARACTERS));
  if (base64.length % 4 !== 0 || end.length < 4) throw torn("the file is truncated");
  const size = new DataView(end.buffer, end.length - 4).getUint32(0, true);
  if (size > RATIO_MAX * base64.length) throw torn("the file is damaged");
  return size;
}

function partsOf(base64: string): ReadableStream<Uint8Array<ArrayBuffer>> {
  let at = 0;
  return new ReadableStream({
    pull(controller) {
      controller.enqueue(decoded(base64.slice(at, at + PART)));
      at += PART;
      if (at >= base64.length) controller.close();
    },
  });
}

function decoded(base64: string): Uint8Array<ArrayBuffer> {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}
