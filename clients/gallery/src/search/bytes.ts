// Texts as the search has them: strings of which each sign is one byte of the UTF-8.
//
// Queries are defined on bytes (clients/browse/query.h): how long they may be, where an error is, how
// near two names are. Working on such strings gives the same answers without a second set of rules.

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

/** The character, counted from 1, that stands at a byte: bytes that go on a character count nothing. */
export function characterAt(bytes: string, byte: number): number {
  let characters = 1;
  for (let at = 0; at < Math.min(byte, bytes.length); ++at)
    if ((bytes.charCodeAt(at) & 0xc0) !== 0x80) ++characters;
  return characters;
}
