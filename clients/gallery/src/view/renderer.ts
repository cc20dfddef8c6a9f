// The page's only WebGL context.
//
// Browsers limit the number of contexts, and each costs memory. So all pictures are drawn here off-screen,
// then handed without a copy to the canvas that shows them. A context can be lost at any time (driver
// restart, wake-up of a laptop). Until the context is restored, nothing is drawn; then three.js uploads
// everything again, and the listeners draw again.

import { type Camera, type Scene, SRGBColorSpace, WebGLRenderer } from "three";

/** A part of a picture, in pixels from the upper left. */
export interface Viewport {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

/** A canvas that shows pictures. Its size in pixels is that of the last picture. */
export class Screen {
  private readonly context: ImageBitmapRenderingContext | null;

  constructor(readonly canvas: HTMLCanvasElement) {
    // Transparent, so that the page shows through until the first picture.
    this.context = canvas.getContext("bitmaprenderer");
  }

  show(picture: ImageBitmap): void {
    const { width, height } = picture;
    if (this.canvas.width !== width) this.canvas.width = width;
    if (this.canvas.height !== height) this.canvas.height = height;
    this.context?.transferFromImageBitmap(picture);
  }
}

const RATIO_MAX = 2;
/** With software rendering, every pixel costs time. */
const RATIO_MAX_SOFTWARE = 1;

/** A context and its drawing surface. */
interface Context {
  readonly surface: OffscreenCanvas;
  readonly gl: WebGLRenderer;
}

export class SharedRenderer {
  /** Created at the first use, because this takes as long as loading an archive. */
  private made: { readonly context: Context | null; readonly isSoftware: boolean } | undefined;
  private lost = false;
  private readonly restored = new Set<() => void>();

  private get ready(): { readonly context: Context | null; readonly isSoftware: boolean } {
    if (this.made !== undefined) return this.made;
    const isSoftware = drawsInSoftware();
    this.made = { context: contextOf(!isSoftware), isSoftware };
    const { context } = this.made;
    context?.surface.addEventListener("webglcontextlost", () => { this.lost = true; });
    context?.surface.addEventListener("webglcontextrestored", () => {
      this.lost = false;
      for (const again of this.restored) again();
    });
    return this.made;
  }
  private get context(): Context | null { return this.ready.context; }
  /** Whether WebGL renders in software. */
  get isSoftware(): boolean { return this.ready.isSoftware; }

  /** Whether WebGL is available. The first call creates the context. */
  get available(): boolean { return this.context !== null; }
  get isLost(): boolean {
    // Check the context too, because the browser's event about a lost context arrives a little later.
    return this.lost || (this.context !== null && this.context.gl.getContext().isContextLost());
  }

  /** Device pixels per CSS pixel. */
  get pixelRatio(): number {
    return Math.min(window.devicePixelRatio || 1, this.isSoftware ? RATIO_MAX_SOFTWARE : RATIO_MAX);
  }

  /** Returns a function that removes the listener. */
  onRestored(again: () => void): () => void {
    this.restored.add(again);
    return () => { this.restored.delete(again); };
  }

  /** Starts a picture of this size, filled with the colour; false if nothing can be drawn now. Alternating
   *  sizes are slow, because each change creates a new surface. */
  begin(width: number, height: number, colour: number): boolean {
    if (this.context === null || this.isLost || width < 1 || height < 1) return false;
    const { gl, surface } = this.context;
    if (width !== surface.width || height !== surface.height) gl.setSize(width, height, false);
    gl.setScissorTest(false);
    gl.setViewport(0, 0, width, height);
    gl.setClearColor(colour, 1);
    gl.clear();
    return true;
  }

  /** REQUIRES: begin() returned true. */
  draw(scene: Scene, camera: Camera, into: Viewport, background: number): void {
    if (this.context === null) return;
    const { gl, surface } = this.context;
    const y = surface.height - into.y - into.height;
    gl.setViewport(into.x, y, into.width, into.height);
    gl.setScissor(into.x, y, into.width, into.height);
    gl.setScissorTest(true);
    gl.setClearColor(background, 1);
    gl.clear();
    gl.render(scene, camera);
  }

  /** Hands over the picture. Must be called in the same task as draw(). */
  finish(to: Screen): void {
    if (this.context === null || this.isLost) return;
    try {
      to.show(this.context.surface.transferToImageBitmap());
    } catch {
      // The context was just lost: listeners are notified later.
    }
  }

  /** For tests: loses the context; returns a function that restores it. */
  loseContext(): () => void {
    const extension = this.context?.gl.getContext().getExtension("WEBGL_lose_context");
    extension?.loseContext();
    return () => extension?.restoreContext();
  }
}

function contextOf(antialias: boolean): Context | null {
  if (typeof OffscreenCanvas === "undefined") return null;
  try {
    const surface = new OffscreenCanvas(1, 1);
    const gl = new WebGLRenderer({
      canvas: surface, antialias, alpha: false, powerPreference: "high-performance",
    });
    gl.outputColorSpace = SRGBColorSpace;
    gl.setPixelRatio(1);
    gl.autoClear = false;
    return { surface, gl };
  } catch {
    return null;
  }
}

/** Checked with a separate context, because antialiasing can only be chosen at creation. */
function drawsInSoftware(): boolean {
  if (typeof OffscreenCanvas === "undefined") return false;
  const context = new OffscreenCanvas(1, 1).getContext("webgl2");
  if (context === null) return false;
  const names = context.getExtension("WEBGL_debug_renderer_info");
  const name: unknown = context.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : context.RENDERER);
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return typeof name === "string" && /llvmpipe|swiftshader|software|softpipe/i.test(name);
}
