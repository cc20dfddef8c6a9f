// Trails: the paths of the bodies' centres up to a time, as lines.
//
// All pieces of all bodies are in one buffer in the order of time, so that "up to now" is a count.

import { BufferAttribute, BufferGeometry, Color, LineBasicMaterial, LineSegments } from "three";
import type { Mesh } from "../data/types";
import { firstPast } from "../motion/bisection";
import { Pose } from "../motion/pose";
import type { Recording } from "../motion/recording";
import { positionInto } from "../motion/segments";
import type { ArchiveStage } from "./stage";

/** Maximum deviation of a line from the curve, as a share of the view's diagonal. */
const STRAY_SHARE = 1 / 2500;
const PIECES_PER_SEGMENT_MAX = 48;

interface Piece {
  readonly time: number;
  readonly body: number;
  readonly from: readonly [number, number, number];
  readonly to: readonly [number, number, number];
}

export class Trails {
  readonly lines: LineSegments<BufferGeometry, LineBasicMaterial>;
  /** Times when pieces are complete; ascending. */
  private readonly times: Float64Array;

  constructor(recording: Recording, stage: ArchiveStage, own: readonly Mesh[]) {
    const { low, high } = stage.box;
    const stray = STRAY_SHARE * Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
    const pieces: Piece[] = [];
    for (let body = 0; body < recording.bodies; ++body) addPieces(pieces, recording, body, stray);
    pieces.sort((a, b) => a.time - b.time);
    this.times = Float64Array.from(pieces, (piece) => piece.time);
    const geometry = new BufferGeometry();
    const places = new Float32Array(6 * pieces.length);
    const colours = new Float32Array(6 * pieces.length);
    const colourOf = coloursOf([...stage.looks.meshes, ...own], recording.bodies);
    pieces.forEach((piece, i) => {
      places.set(piece.from, 6 * i);
      places.set(piece.to, 6 * i + 3);
      const { r, g, b } = colourOf[piece.body]!;
      colours.set([r, g, b, r, g, b], 6 * i);
    });
    geometry.setAttribute("position", new BufferAttribute(places, 3));
    geometry.setAttribute("color", new BufferAttribute(colours, 3));
    const material = new LineBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false });
    this.lines = new LineSegments(geometry, material);
    this.lines.frustumCulled = false;
    this.lines.renderOrder = 1;
  }

  show(t: number, opacity: number): void {
    const count = firstPast(this.times.length, (i) => this.times[i]! > t);
    this.lines.visible = count > 0;
    this.lines.geometry.setDrawRange(0, 2 * count);
    this.lines.material.opacity = opacity;
  }

  dispose(): void {
    this.lines.geometry.dispose();
    this.lines.material.dispose();
  }
}

/** A trail has the colour of the body's first mesh. */
function coloursOf(meshes: readonly Mesh[], bodies: number): Color[] {
  const colours = Array.from({ length: bodies }, () => new Color(0x808080));
  const isSet = new Uint8Array(bodies);
  for (const mesh of meshes) {
    if (mesh.feature >= bodies || isSet[mesh.feature]) continue;
    isSet[mesh.feature] = 1;
    const colour = colours[mesh.feature]!.set(mesh.colour);
    // An almost white trail would be invisible on a white table.
    if (colour.r + colour.g + colour.b > 2.4) colour.set(0x6b7280);
  }
  return colours;
}

const pose = new Pose();

function addPieces(pieces: Piece[], recording: Recording, body: number, stray: number): void {
  const { segments } = recording;
  const end = recording.endSegment(body);
  let from: [number, number, number] | null = null;
  const step = (index: number, t: number, isLast: boolean): void => {
    positionInto(segments, index, t, pose);
    const to: [number, number, number] = [pose.x, pose.z, -pose.y];
    if (from === null) {
      from = to;
      return;
    }
    // Skip short pieces, because micro-impacts would create thousands of invisible ones.
    const length = Math.hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
    if (length < 3 * stray && !isLast) return;
    pieces.push({ time: t, body, from, to });
    from = to;
  };
  for (let i = recording.firstSegment(body); i < end; ++i) {
    const start = segments.startS[i]!;
    step(i, start, i === end - 1);
    if (i === end - 1) break;
    const duration = segments.startS[i + 1]! - start;
    const a = segments.acceleration;
    const bow = (Math.hypot(a[3 * i]!, a[3 * i + 1]!, a[3 * i + 2]!) * duration * duration) / 8;
    const count = Math.min(Math.max(Math.ceil(Math.sqrt(bow / stray)), 1), PIECES_PER_SEGMENT_MAX);
    for (let k = 1; k < count; ++k) step(i, start + (duration * k) / count, false);
  }
}
