// The material of all solid features: soft light from above and below and a lamp, computed per vertex.
//
// In software rendering, pixels are the main cost. So light is computed at the vertices and interpolated; on
// flat faces and small balls the result looks the same.

import { Color, DoubleSide, FrontSide, ShaderMaterial, Vector3 } from "three";
import type { Theme } from "./theme";

const VERTEX = `
uniform vec3 tint;
uniform vec3 sky;
uniform vec3 ground;
uniform vec3 lamp;
uniform vec3 towardsLamp;
varying vec3 shade;

vec3 displayed(vec3 linear) {
  vec3 c = clamp(linear, 0.0, 1.0);
  return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}

void main() {
  vec4 place = vec4(position, 1.0);
  vec3 up = normal;
  #ifdef USE_INSTANCING
    place = instanceMatrix * place;
    up = mat3(instanceMatrix) * up;
  #endif
  place = modelMatrix * place;
  #ifdef BOTH_SIDES
    if (dot(up, cameraPosition - place.xyz) < 0.0) up = -up;
  #endif
  vec3 light = mix(ground, sky, 0.5 + 0.5 * up.y) + lamp * max(dot(up, towardsLamp), 0.0);
  vec3 colour = tint;
  #ifdef USE_INSTANCING_COLOR
    colour *= instanceColor;
  #endif
  shade = displayed(colour * light);
  gl_Position = projectionMatrix * viewMatrix * place;
}`;
const FRAGMENT = `
uniform float opacity;
varying vec3 shade;
void main() {
  gl_FragColor = vec4(shade, opacity);
}`;

/** Light shared by all materials of a stage. */
export class Light {
  readonly uniforms = {
    sky: { value: new Color() },
    ground: { value: new Color() },
    lamp: { value: new Color() },
    towardsLamp: { value: new Vector3(-0.45, 1, 0.6).normalize() },
  };

  set(theme: Theme): void {
    const { sky, ground, lamp } = this.uniforms;
    sky.value.set(theme.sky).multiplyScalar(theme.skyStrength);
    ground.value.set(theme.ground).multiplyScalar(theme.skyStrength);
    lamp.value.set(0xffffff).multiplyScalar(theme.lampStrength);
  }
}

export interface Finish {
  readonly colour: string;
  readonly opacity: number;
  readonly doubleSided: boolean;
  /** Whether the mesh is on a surface and must be drawn in front of it. */
  readonly isDecal: boolean;
}

export function shaded(light: Light, finish: Finish): ShaderMaterial {
  const isClear = finish.opacity < 1;
  return new ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    uniforms: {
      ...light.uniforms, tint: { value: new Color(finish.colour) }, opacity: { value: finish.opacity },
    },
    defines: finish.doubleSided ? { BOTH_SIDES: 1 } : {},
    transparent: isClear,
    // Transparent features must not hide others.
    depthWrite: !isClear,
    side: finish.doubleSided ? DoubleSide : FrontSide,
    polygonOffset: finish.isDecal,
    polygonOffsetFactor: -1,
    polygonOffsetUnits: -4,
  });
}
