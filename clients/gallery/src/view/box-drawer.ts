// Shows the box of box.ts in a scene, and converts drags to changes of the box.

import {
  BoxGeometry, BufferAttribute, BufferGeometry, DynamicDrawUsage, EdgesGeometry, Group, LineBasicMaterial,
  LineSegments, Mesh, MeshBasicMaterial, type PerspectiveCamera, Points, PointsMaterial, Vector3, DoubleSide,
} from "three";
import type { Place } from "../data/types";
import { setYUp } from "./axes";
import {
  alongAxis, type Box, dragged, type Face, faceMiddle, FACES, onPlane, type Ray, soundBox, withFace,
} from "./box";
import { middleOf, type ViewBox } from "./camera";
import type { PointInCell } from "./views";
import { THEMES, type ThemeName } from "./theme";

/** Maximum distance from the pointer to a handle. */
const HANDLE_REACH_PX = 14;
const HANDLE_PX = 12;
/** Below this elevation, the ground is too oblique for drawing. */
const GROUND_ELEVATION_MIN = 0.3;

type Drag = { readonly face: Face } | { readonly from: Place; readonly axis: 1 | 2; readonly at: number };

const place = new Vector3();

export class BoxDrawer {
  readonly group = new Group();
  box: Box | null = null;
  /** Whether the next drag draws a new box. */
  isArmed = false;
  private drag: Drag | null = null;
  private readonly fill = new MeshBasicMaterial({
    transparent: true, opacity: 0.16, depthWrite: false, side: DoubleSide,
  });
  private readonly edge = new LineBasicMaterial({ transparent: true, depthTest: false, opacity: 0.9 });
  private readonly dot = new PointsMaterial({ sizeAttenuation: false, depthTest: false, transparent: true });
  private readonly solid = new Mesh(new BoxGeometry(1, 1, 1), this.fill);
  private readonly edges = new LineSegments(new EdgesGeometry(this.solid.geometry), this.edge);
  private readonly handles: Points<BufferGeometry, PointsMaterial>;
  private readonly handlePlaces = new BufferAttribute(new Float32Array(3 * FACES.length), 3);

  constructor() {
    this.handlePlaces.setUsage(DynamicDrawUsage);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", this.handlePlaces);
    this.handles = new Points(geometry, this.dot);
    this.handles.frustumCulled = false;
    this.solid.renderOrder = 4;
    this.edges.renderOrder = 5;
    this.handles.renderOrder = 6;
    this.group.add(this.solid, this.edges, this.handles);
    this.group.visible = false;
    this.setTheme("light");
  }

  setTheme(name: ThemeName): void {
    this.fill.color.set(THEMES[name].box);
    this.edge.color.set(THEMES[name].box);
    this.dot.color.set(THEMES[name].handle);
  }

  set(box: Box | null): void {
    this.box = box === null ? null : soundBox(box);
    this.drag = null;
    this.update();
  }

  setRatio(ratio: number): void { this.dot.size = HANDLE_PX * ratio; }

  /** Starts a drag. `view` is the scene's; `elevation` is the camera's. */
  grab(point: PointInCell, camera: PerspectiveCamera, view: ViewBox, elevation: number): boolean {
    const face = this.handleAt(point, camera);
    if (face !== null) {
      this.drag = { face };
      return true;
    }
    if (!this.isArmed) return false;
    const axis = Math.abs(elevation) >= GROUND_ELEVATION_MIN ? 2 : 1;
    const at = axis === 2
      ? Math.max(view.low[2], Math.min(0, view.high[2]))
      : 0.5 * (view.low[1] + view.high[1]);
    const from = onPlane(point.ray, axis, at);
    if (from === null) return false;
    this.drag = { from, axis, at };
    return true;
  }

  /** Returns true if the box has changed. */
  grabbed(ray: Ray, view: ViewBox): boolean {
    const { drag, box } = this;
    if (drag === null) return false;
    if ("face" in drag) {
      if (box === null) return false;
      const at = alongAxis(ray, faceMiddle(box, drag.face), drag.face.axis);
      if (at === null) return false;
      this.box = withFace(box, drag.face, at);
    } else {
      const to = onPlane(ray, drag.axis, drag.at);
      if (to === null) return false;
      this.box = dragged(drag.from, to, drag.axis, view);
    }
    this.update();
    return true;
  }

  released(): void {
    if (this.drag !== null && !("face" in this.drag)) this.isArmed = false;
    this.drag = null;
  }

  /** The handle under the pointer; null: none. */
  handleAt(point: PointInCell, camera: PerspectiveCamera): Face | null {
    const { box } = this;
    const { x, y, width, height } = point;
    if (box === null) return null;
    let nearest: Face | null = null;
    let reach = HANDLE_REACH_PX;
    for (const face of FACES) {
      setYUp(place, faceMiddle(box, face)).project(camera);
      const distance = Math.hypot(0.5 * (place.x + 1) * width - x, 0.5 * (1 - place.y) * height - y);
      if (place.z > 1 || distance >= reach) continue;
      reach = distance;
      nearest = face;
    }
    return nearest;
  }

  private update(): void {
    const { box } = this;
    this.group.visible = box !== null;
    if (box === null) return;
    for (const object of [this.solid, this.edges]) {
      setYUp(object.position, middleOf(box));
      object.scale.set(box.high[0] - box.low[0], box.high[2] - box.low[2], box.high[1] - box.low[1]);
    }
    FACES.forEach((face, i) => {
      setYUp(place, faceMiddle(box, face));
      this.handlePlaces.setXYZ(i, place.x, place.y, place.z);
    });
    this.handlePlaces.needsUpdate = true;
  }
}
