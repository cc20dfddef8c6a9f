// The `sleight export` command for the selected animations. The page itself doesn't write files.
import { joined, type SignedQuery } from "./query-text";

/** Quotes a word for the shell if it contains special characters. */
export function shellWord(word: string): string {
  if (/^[A-Za-z0-9_@%+=:,./-]+$/.test(word) && !word.startsWith("-")) return word;
  return `'${word.replaceAll("'", `'\\''`)}'`;
}

/** Exports the selected animations; without a selection, all that match the queries. */
export function exportLine(
  archive: string,
  chosen: readonly string[],
  queries: readonly SignedQuery[],
): string {
  const words = ["sleight", "export", shellWord(archive)];
  if (chosen.length > 0) words.push("--ids", ...chosen.map(shellWord));
  else if (queries.length > 0) words.push("--select", shellWord(joined(queries)));
  else words.push("--all");
  const single = chosen.length === 1 ? chosen[0] : undefined;
  words.push("-o", single === undefined ? "animations" : shellWord(`${single}.glb`));
  return words.join(" ");
}
