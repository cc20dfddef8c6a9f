// Runs the unit tests with Node's own runner: `npm test [-- NAME...]` for NAME.test.ts files.
//
// The tests are bundled (with Vite's esbuild) into a temporary folder and run in one process.
import { spawnSync } from "node:child_process";
import { mkdtempSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { fileURLToPath } from "node:url";
import { bundled } from "./bundle.mjs";

const here = fileURLToPath(new URL(".", import.meta.url));
const chosen = process.argv.slice(2);
const tests = readdirSync(here)
  .filter((name) => name.endsWith(".test.ts"))
  .filter((name) => chosen.length === 0 || chosen.includes(basename(name, ".test.ts")))
  .sort();
if (tests.length === 0) {
  console.error(`no such test in ${here}`);
  process.exit(2);
}
const folder = mkdtempSync(join(tmpdir(), "sleight-gallery-test-"));
try {
  const bundle = join(folder, "all.mjs");
  await bundled(tests, bundle);
  const options = ["--enable-source-maps", "--test", bundle];
  const { status } = spawnSync(process.execPath, options, { stdio: "inherit" });
  process.exitCode = status ?? 1;
} finally {
  rmSync(folder, { recursive: true, force: true });
}
