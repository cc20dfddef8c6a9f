// Bytes of a saved gallery's file: base64 of what gzip made of them.
//
// It goes part by part, so that a large file neither stands in memory several times over nor holds up
// the page.

import { Turns } from "../search/turns";
import { torn } from "./packed";
import { SourceError } from "./source";

/** Characters at once; a multiple of four, as four of them are three bytes. */
const PART = 1 << 18;
/** Deflate makes no less of its bytes: a file that claims more is torn. */
const RATIO_MAX = 1032;
/** gzip's end: the bytes' checksum and their number, four bytes each. */
const TRAILER_CHARACTERS = 8;

/** Throws SourceError("torn"); "other" where the browser can't do it. */
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
    // Throws where there are more bytes than gzip's end says.
    bytes.set(value, filled);
    filled += value.length;
    if (turns.isDue()) await turns.take();
  }
  if (filled !== bytes.length) throw torn("the file is truncated");
  return bytes.buffer;
}

/** What gzip's end says. */
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
