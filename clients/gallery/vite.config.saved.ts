// Builds the page of a saved gallery: index.html, app.js and app.css. `sleight gallery --save` adds the data.
//
// The page also opens by double-click. Browsers don't load modules from files, so all code is one classic
// script. The folder is SLEIGHT_GALLERY_SAVED_OUT, or `--outDir`, or dist-saved beside this file. The same
// sources always produce the same bytes.
import { readFileSync } from "node:fs";
import { defineConfig, type Plugin } from "vite";

const MODULE = '    <script type="module" src="/src/main.ts"></script>\n';

// No server sends the policy, so the page contains it. Chromium treats all files as 'self'; `file:` is for
// browsers in which each file is its own origin. Pages served by a web server load nothing from `file:`.
const POLICY = [
  "default-src 'none'",
  "script-src 'self' file:",
  "style-src 'self' file:",
  "img-src 'self' file: blob: data:",
  "base-uri 'none'",
  "form-action 'none'",
].join("; ");

// The policy comes first, because it applies only to what follows.
const HEAD = `<head>
    <meta http-equiv="Content-Security-Policy" content="${POLICY}" />`;
const FILES = `    <link rel="stylesheet" href="app.css" />
    <script src="app.js" defer></script>
  </head>`;

/** The page is index.html with other files. */
function page(): Plugin {
  return {
    name: "saved-page",
    generateBundle() {
      let html = readFileSync(new URL("index.html", import.meta.url), "utf8");
      for (const [from, to] of [[MODULE, ""], ["<head>", HEAD], ["  </head>", FILES]] as const) {
        if (html.split(from).length !== 2) throw new Error(`index.html: '${from.trim()}' must occur exactly once`);
        html = html.replace(from, () => to);
      }
      this.emitFile({ type: "asset", fileName: "index.html", source: html });
    },
  };
}

export default defineConfig({
  base: "./",
  publicDir: false,
  clearScreen: false,
  plugins: [page()],
  build: {
    outDir: process.env.SLEIGHT_GALLERY_SAVED_OUT ?? "dist-saved",
    emptyOutDir: true,
    target: "es2022",
    sourcemap: false,
    cssCodeSplit: false,
    assetsInlineLimit: 0,
    modulePreload: false,
    chunkSizeWarningLimit: 1000,
    rollupOptions: {
      input: "src/main-saved.ts",
      output: {
        format: "iife",
        inlineDynamicImports: true,
        entryFileNames: "app.js",
        assetFileNames: "app[extname]",
      },
    },
  },
});
