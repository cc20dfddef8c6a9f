// People's words for the balls' colours: a few words by hue, which shading doesn't change.

const words = [
  { word: "yellow", from: 40, to: 72 },
  { word: "lime", from: 72, to: 113 },
  { word: "green", from: 113, to: 163 },
  { word: "teal", from: 163, to: 198 },
  { word: "blue", from: 198, to: 246 },
  { word: "violet", from: 246, to: 330 },
];

/** Hue in degrees; red, green and blue are 0..255. */
export function hueOf([red, green, blue]) {
  const most = Math.max(red, green, blue);
  const spread = most - Math.min(red, green, blue);
  if (spread === 0) return 0;
  let sixth = (red - green) / spread + 4;
  if (most === red) sixth = (green - blue) / spread;
  else if (most === green) sixth = (blue - red) / spread + 2;
  return (60 * sixth + 360) % 360;
}

/** null: not a ball's colour. */
export function wordOf(rgb) {
  const hue = hueOf(rgb);
  return words.find(({ from, to }) => hue >= from && hue < to)?.word ?? null;
}

export function rgbOf(hex) {
  return [1, 3, 5].map((at) => Number.parseInt(hex.slice(at, at + 2), 16));
}
