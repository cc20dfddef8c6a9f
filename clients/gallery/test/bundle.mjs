// Bundles tests and test programs into one file for Node: node bundle.mjs ENTRY.ts OUT.mjs
import { realpathSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = fileURLToPath(new URL(".", import.meta.url));

/** Bundles the modules of this folder in their order. */
export function bundled(names, outfile) {
  const contents = names.map((name) => `import "./${name}";`).join("\n");
  return build({
    stdin: { contents, resolveDir: here },
    outfile,
    bundle: true,
    format: "esm",
    platform: "node",
    target: "node18",
    sourcemap: "inline",
    logLevel: "warning",
  });
}

if (realpathSync(process.argv[1]) === fileURLToPath(import.meta.url))
  await bundled([process.argv[2]], process.argv[3]);
