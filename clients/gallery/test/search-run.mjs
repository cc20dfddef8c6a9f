// Bundles search-program.ts and runs it: node search-run.mjs INDEX QUESTIONS
import { spawnSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const folder = mkdtempSync(join(tmpdir(), "sleight-gallery-search-"));
const program = join(folder, "search-program.mjs");
try {
  await build({
    entryPoints: [join(dirname(fileURLToPath(import.meta.url)), "search-program.ts")],
    outfile: program,
    bundle: true,
    format: "esm",
    platform: "node",
    target: "node18",
    logLevel: "warning",
  });
  const { status } = spawnSync(process.execPath, [program, ...process.argv.slice(2)], { stdio: "inherit" });
  process.exitCode = status ?? 1;
} finally {
  rmSync(folder, { recursive: true, force: true });
}
