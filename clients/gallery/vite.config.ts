// Builds the page into one folder of static files that any web server, or a file manager, can hold.
//
// The folder is SLEIGHT_GALLERY_OUT, or `--outDir`, or dist beside this file. Two builds of the same
// sources give the same bytes: names hold the content's hash and nothing holds the time or a path.
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
    // Inlined files would be data: addresses, which the page's policy lets only images have.
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    // The budget is for what is sent, compressed; the browser tests hold it.
    chunkSizeWarningLimit: 1000,
    rollupOptions: {
      output: {
        entryFileNames: "assets/[name]-[hash].js",
        chunkFileNames: "assets/[name]-[hash].js",
        assetFileNames: "assets/[name]-[hash][extname]",
        manualChunks(id: string): string | undefined {
          // Fetched by the plots' view alone.
          return id.includes("/node_modules/uplot/") ? "uplot" : undefined;
        },
      },
    },
  },
});
