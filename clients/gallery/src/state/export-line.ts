// The command line that exports what is chosen: `sleight export` makes the files, the page makes none.
import { joined, type SignedQuery } from "./query-text";

/** As a shell takes it: in single quotes where it has other signs than plain ones. */
export function shellWord(word: string): string {
  if (/^[A-Za-z0-9_@%+=:,./-]+$/.test(word) && !word.startsWith("-")) return word;
  return `'${word.replaceAll("'", `'\\''`)}'`;
}

/** Of what is chosen; where nothing is, of all that the queries let through. */
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
