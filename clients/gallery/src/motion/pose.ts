// Position and orientation of a body, in the scene's frame (right-handed, z up, metres).

/** An output parameter of functions that evaluate motion; reused from frame to frame. */
export class Pose {
  x = 0;
  y = 0;
  z = 0;
  /** A unit quaternion from the body's frame to the scene's. */
  qw = 1;
  qx = 0;
  qy = 0;
  qz = 0;
}
