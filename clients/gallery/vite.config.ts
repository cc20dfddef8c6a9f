// Builds the page into a folder of static files for any web server.
//
// The folder is SLEIGHT_GALLERY_OUT, or `--outDir`, or dist beside this file. Equal sources build to equal
// bytes: names contain the content's hash, and no file contains a time or path.
import { defineConfig } from "vite";

export default defineConfig({
  base: "./",
  publicDir: false,
  clearScreen: false,
  build: {
    outDir: process.env.SLEIGHT_GALLERY_OUT ?? "dist",
    emptyOutDir: true,
    target: "es2022",
    sourcemap: false,
    cssCodeSplit: true,
    // Inlined files would be data: addresses, which the page's policy allows only for images.
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    // The browser tests check the budget, which counts compressed bytes.
    chunkSizeWarningLimit: 1000,
    rollupOptions: {
      output: {
        entryFileNames: "assets/[name]-[hash].js",
        chunkFileNames: "assets/[name]-[hash].js",
        assetFileNames: "assets/[name]-[hash][extname]",
        manualChunks(id: string): string | undefined {
          // This code is loaded only by the plots' view.
          return id.includes("/node_modules/uplot/") ? "uplot" : undefined;
        },
      },
    },
  },
});
