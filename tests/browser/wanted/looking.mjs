// Looks at a picture of an animation's end: are balls of these colours at the remembered places?
//
// Only the picture is used, not the page's data. All cards show the scene from the same direction, so the
// bins that spell HI are always at the same places. In each bin the densest patch of colour is the ball;
// thinner patches are trails.
import { wordOf } from "./colours.mjs";

/** Of 16 balls, this many may look like a neighbouring colour. */
const mistakenMax = 1;

const order = ["violet", "blue", "teal", "green", "lime", "yellow"];

export async function looksLike(canvas, rests) {
  const seen = await ballsSeen(canvas);
  if (seen.includes(null)) return false;
  let mistaken = 0;
  for (const [i, { word }] of rests.entries()) {
    const off = Math.abs(order.indexOf(word) - order.indexOf(seen[i]));
    if (off > 1) return false;
    mistaken += off;
  }
  return mistaken <= mistakenMax;
}

/** Shares of the picture's width and height, by rows from the furthest, each row from the left. */
const places = [
  [75, 68], [107, 70], [140, 76],
  [72, 81], [104, 85], [139, 89],
  [67, 95], [86, 97], [102, 99], [139, 103],
  [64, 112], [99, 114], [136, 120],
  [60, 127], [97, 131], [133, 136],
].map(([x, y]) => [x / 207, y / 171]);

/** Colour words of the balls at those places; null if no ball is visible. */
async function ballsSeen(canvas) {
  const picture = await canvas.evaluate(async (element) => {
    const bitmap = await createImageBitmap(element);
    const { width, height } = bitmap;
    const context = new OffscreenCanvas(width, height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    return { width, height, bytes: Array.from(context.getImageData(0, 0, width, height).data) };
  });
  const { width, height } = picture;
  return places.map(([x, y]) => ballAt(picture, Math.round(x * width), Math.round(y * height)));
}

/** In pixels: maximum distance of a ball from a bin's middle, and half of a ball's visible size. */
const strayPx = 4;
const halfPx = 3;
/** Balls have stronger colours than anything else. */
const fullColour = 45;

function ballAt({ width, height, bytes }, x, y) {
  let best = { full: 0, rgb: [0, 0, 0] };
  for (let atY = y - strayPx; atY <= y + strayPx; atY++) {
    for (let atX = x - strayPx; atX <= x + strayPx; atX++) {
      const patch = patchAt(atX, atY);
      if (patch.full > best.full) best = patch;
    }
  }
  const enough = 0.6 * (2 * halfPx + 1) ** 2;
  return best.full < enough ? null : wordOf(best.rgb);

  function patchAt(centreX, centreY) {
    const sum = [0, 0, 0];
    let full = 0;
    for (let py = Math.max(0, centreY - halfPx); py <= Math.min(height - 1, centreY + halfPx); py++) {
      for (let px = Math.max(0, centreX - halfPx); px <= Math.min(width - 1, centreX + halfPx); px++) {
        const at = 4 * (py * width + px);
        const rgb = [bytes[at], bytes[at + 1], bytes[at + 2]];
        if (Math.max(...rgb) - Math.min(...rgb) < fullColour) continue;
        full++;
        rgb.forEach((value, i) => (sum[i] += value));
      }
    }
    return { full, rgb: sum.map((value) => value / Math.max(1, full)) };
  }
}
