// Texts for the search: strings in which each character is one byte of UTF-8.
//
// Queries are defined on bytes (clients/browse/query.h): their maximum length, positions of errors, and
// similarity of names. With such strings, the page's rules yield the same answers as the server's.

const PART = 4096;

export function bytesOf(text: string): string {
  const encoded = new TextEncoder().encode(text);
  let bytes = "";
  for (let at = 0; at < encoded.length; at += PART)
    bytes += String.fromCharCode(...encoded.subarray(at, at + PART));
  return bytes;
}

export function textOf(bytes: string): string {
  return new TextDecoder().decode(Uint8Array.from(bytes, (sign) => sign.charCodeAt(0)));
}

/** The character at a byte, counted from 1. Continuation bytes don't count. */
export function characterAt(bytes: string, byte: number): number {
  let characters = 1;
  for (let at = 0; at < Math.min(byte, bytes.length); ++at)
    if ((bytes.charCodeAt(at) & 0xc0) !== 0x80) ++characters;
  return characters;
}
