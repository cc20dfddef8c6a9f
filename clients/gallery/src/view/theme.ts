// Colours of the 3D views in the light and dark themes.

export type ThemeName = "light" | "dark";

export interface Theme {
  readonly background: number;
  /** Colour of the gaps between animations. */
  readonly divider: number;
  /** Strengths of light from above, light from below, and the lamp. */
  readonly sky: number;
  readonly ground: number;
  readonly skyStrength: number;
  readonly lampStrength: number;
  /** Opacity of trails, and colours of marks and drawn boxes. */
  readonly trailOpacity: number;
  readonly mark: number;
  readonly box: number;
  readonly handle: number;
}

export const THEMES: Readonly<Record<ThemeName, Theme>> = {
  light: {
    background: 0xc9d3df,
    divider: 0x8a94a3,
    sky: 0xffffff,
    ground: 0x9a9fa8,
    skyStrength: 0.53,
    lampStrength: 0.53,
    trailOpacity: 0.75,
    mark: 0xb00020,
    box: 0x0b57d0,
    handle: 0x0b57d0,
  },
  dark: {
    background: 0x14171c,
    divider: 0x3d434d,
    sky: 0xdfe6f5,
    ground: 0x4a4d55,
    skyStrength: 0.42,
    lampStrength: 0.54,
    trailOpacity: 0.8,
    mark: 0xffb4a8,
    box: 0x8ab4f8,
    handle: 0xa8c7fa,
  },
};
