// Bundles evaluate.ts into one file for Node: node build-evaluate.mjs OUT.mjs
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const [out] = process.argv.slice(2);
if (out === undefined) {
  console.error("usage: node build-evaluate.mjs OUT.mjs");
  process.exit(2);
}
await build({
  entryPoints: [join(dirname(fileURLToPath(import.meta.url)), "evaluate.ts")],
  outfile: out,
  bundle: true,
  format: "esm",
  platform: "node",
  target: "node18",
  logLevel: "warning",
});
