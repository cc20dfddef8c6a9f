// The page's one WebGL context.
//
// Browsers hold few contexts and each costs memory, so every picture of the page is drawn here, off
// the screen, and then handed to the canvas that shows it, without a copy. A context can be lost at
// any time (a driver that starts anew, a laptop that wakes up): then nothing is drawn until it is
// back, three.js uploads everything again, and the listeners draw again.

import { type Camera, type Scene, SRGBColorSpace, WebGLRenderer } from "three";

/** A part of a picture, in its pixels from the upper left. */
export interface Viewport {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

/** A canvas that shows pictures; its size in pixels is the newest picture's. */
export class Screen {
  private readonly context: ImageBitmapRenderingContext | null;

  constructor(readonly canvas: HTMLCanvasElement) {
    // Not opaque: until the first picture the page is seen through it.
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
/** Where the processor draws, each pixel counts. */
const RATIO_MAX_SOFTWARE = 1;

/** A context and what it draws on. */
interface Context {
  readonly surface: OffscreenCanvas;
  readonly gl: WebGLRenderer;
}

export class SharedRenderer {
  /** Undefined until it is needed: to make one takes as long as to load an archive. */
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
  /** Whether the processor draws. */
  get isSoftware(): boolean { return this.ready.isSoftware; }

  /** False: there is no WebGL here at all. To ask makes the context. */
  get available(): boolean { return this.context !== null; }
  get isLost(): boolean {
    // The event comes a little later than the loss.
    return this.lost || (this.context !== null && this.context.gl.getContext().isContextLost());
  }

  /** How many pixels of a picture there are to one of CSS. */
  get pixelRatio(): number {
    return Math.min(window.devicePixelRatio || 1, this.isSoftware ? RATIO_MAX_SOFTWARE : RATIO_MAX);
  }

  /** Returns what ends it. */
  onRestored(again: () => void): () => void {
    this.restored.add(again);
    return () => { this.restored.delete(again); };
  }

  /**
   * Begins a picture of this size with nothing but this colour in it; false: nothing can be drawn
   * now. Sizes that alternate are slow, as each change makes a new surface.
   */
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

  /** REQUIRES: begin() was true. */
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

  /** Hands the picture over; in the same task as it was drawn. */
  finish(to: Screen): void {
    if (this.context === null || this.isLost) return;
    try {
      to.show(this.context.surface.transferToImageBitmap());
    } catch {
      // Lost just now: its listeners will hear of it.
    }
  }

  /** For tests: loses the context as a driver would; returns what brings it back. */
  loseContext(): () => void {
    const extension = this.context?.gl.getContext().getExtension("WEBGL_lose_context");
    extension?.loseContext();
    return () => extension?.restoreContext();
  }

  dispose(): void {
    this.made?.context?.gl.dispose();
    this.restored.clear();
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

/** Asked of a context of its own, as smooth edges can only be had from the beginning. */
function drawsInSoftware(): boolean {
  if (typeof OffscreenCanvas === "undefined") return false;
  const context = new OffscreenCanvas(1, 1).getContext("webgl2");
  if (context === null) return false;
  const names = context.getExtension("WEBGL_debug_renderer_info");
  const name: unknown = context.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : context.RENDERER);
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return typeof name === "string" && /llvmpipe|swiftshader|software|softpipe/i.test(name);
}
