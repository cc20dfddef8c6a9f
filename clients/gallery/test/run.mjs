// Runs the tests by Node's own runner: `npm test [-- NAME...]`, NAME.test.ts each.
//
// Each test is bundled on its own into a folder that goes away; esbuild is Vite's.
import { spawnSync } from "node:child_process";
import { mkdtempSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const chosen = process.argv.slice(2);
const tests = readdirSync(here)
  .filter((name) => name.endsWith(".test.ts"))
  .filter((name) => chosen.length === 0 || chosen.includes(basename(name, ".test.ts")))
  .sort();
if (tests.length === 0) {
  console.error(`there is no such test in ${here}`);
  process.exit(2);
}
const folder = mkdtempSync(join(tmpdir(), "sleight-gallery-test-"));
try {
  await build({
    entryPoints: tests.map((name) => join(here, name)),
    outdir: folder,
    outExtension: { ".js": ".mjs" },
    bundle: true,
    format: "esm",
    platform: "node",
    target: "node18",
    sourcemap: "inline",
    logLevel: "warning",
  });
  const files = tests.map((name) => join(folder, name.replace(/\.ts$/, ".mjs")));
  const options = ["--enable-source-maps", "--test", ...files];
  const { status } = spawnSync(process.execPath, options, { stdio: "inherit" });
  process.exitCode = status ?? 1;
} finally {
  rmSync(folder, { recursive: true, force: true });
}
