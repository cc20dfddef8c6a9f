// Answers requests as a saved page does. tests/programs/test_gallery_search.py compares the answers with
// those of the C++ programs.
//
//   `node bundle.mjs search-program.ts search-program.mjs && node search-program.mjs INDEX QUESTIONS`.
//
// The file QUESTIONS has one JSON object per line, with the key "find" (a text), "groups" (an object with
// "entries", "groups", "by") or "alike" (an object with "to", "entries"). The program prints one answer per
// line, and times to stderr.

import { readFileSync, writeSync } from "node:fs";
import { unpack } from "../src/data/packed";
import type { Grouping } from "../src/search/groups";
import { ArchiveSearch } from "../src/search/search";

interface Question {
  readonly find?: string;
  readonly groups?: {
    readonly entries: number[] | null; readonly groups: number; readonly by: Grouping;
  };
  readonly alike?: { readonly to: number[]; readonly entries: number[] | null };
}

async function answerTo(search: ArchiveSearch, { find, groups, alike }: Question): Promise<unknown> {
  if (find !== undefined) {
    const found = await search.find(find);
    return "message" in found ? found : { entries: found };
  }
  if (groups !== undefined) return search.groups(groups.entries, groups.groups, groups.by);
  if (alike !== undefined) return search.alike(alike.to, alike.entries);
  throw new Error("no question");
}

async function main([indexPath, questionsPath]: readonly string[]): Promise<void> {
  if (indexPath === undefined || questionsPath === undefined) throw new Error("INDEX QUESTIONS");
  const bytes = readFileSync(indexPath);
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength) as ArrayBuffer;
  const begun = performance.now();
  const search = await ArchiveSearch.of(unpack(buffer));
  process.stderr.write(`opened in ${(performance.now() - begun).toFixed(1)} ms\n`);
  const times = new Map<string, number[]>();
  for (const line of readFileSync(questionsPath, "utf8").split("\n")) {
    if (line === "") continue;
    const question = JSON.parse(line) as Question;
    const asked = performance.now();
    const answer = await answerTo(search, question);
    const kind = Object.keys(question)[0] ?? "";
    const list = times.get(kind) ?? [];
    list.push(performance.now() - asked);
    times.set(kind, list);
    writeSync(1, `${JSON.stringify(answer)}\n`);
  }
  for (const [kind, list] of times) {
    const sorted = list.sort((a, b) => a - b);
    const at = (part: number): string => sorted[Math.floor(part * (sorted.length - 1))]!.toFixed(2);
    process.stderr.write(
      `${kind}: ${sorted.length} questions, p50 ${at(0.5)} ms, p99 ${at(0.99)} ms, max ${at(1)} ms\n`);
  }
}

await main(process.argv.slice(2));
