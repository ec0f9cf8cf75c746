// Where the head is and how it is turned, as the window of `omma view` has it: position in metres,
// yaw to the right, pitch up, roll lowers the right side, all in degrees. Matrices are row-major.

const RADIANS = Math.PI / 180;
const STEEPEST_DEG = 89; // beyond, left and right change places

/** Rounded to micrometres and ten thousandths of a degree, so that a link says the very pose. */
export function pose(x, y, z, yaw = 0, pitch = 0, roll = 0) {
  const metres = (value) => Math.round(value * 1e6) / 1e6 + 0;
  const degrees = (value) => {
    const turned = ((((value + 180) % 360) + 360) % 360) - 180;
    return Math.round(turned * 1e4) / 1e4 + 0;
  };
  return {
    x: metres(x), y: metres(y), z: metres(z),
    yaw: degrees(yaw), pitch: degrees(pitch), roll: degrees(roll),
  };
}

/** world_from_head, 16 numbers: the turn is Ry(-yaw) Rx(pitch) Rz(-roll). */
export function matrixOf({ x, y, z, yaw, pitch, roll }) {
  const [cy, sy] = [Math.cos(yaw * RADIANS), Math.sin(yaw * RADIANS)];
  const [cp, sp] = [Math.cos(pitch * RADIANS), Math.sin(pitch * RADIANS)];
  const [cr, sr] = [Math.cos(roll * RADIANS), Math.sin(roll * RADIANS)];
  return Float64Array.of(
    cy * cr + sy * sp * sr, cy * sr - sy * sp * cr, -sy * cp, x,
    -cp * sr, cp * cr, -sp, y,
    sy * cr - cy * sp * sr, sy * sr + cy * sp * cr, cy * cp, z,
    0, 0, 0, 1,
  );
}

/** The pose nearest to a transform, whose scale is left out. */
export function poseFrom(matrix) {
  const column = (k) => {
    const [a, b, c] = [matrix[k], matrix[4 + k], matrix[8 + k]];
    const length = Math.hypot(a, b, c) || 1;
    return [a / length, b / length, c / length];
  };
  const [right, up, back] = [column(0), column(1), column(2)];
  const yaw = Math.atan2(-back[0], back[2]);
  const pitch = Math.asin(Math.min(1, Math.max(-1, -back[1])));
  // What is left of the turn when yaw and pitch are taken away is the roll.
  const level = [Math.cos(yaw), 0, Math.sin(yaw)];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const roll = Math.atan2(dot(up, level), dot(right, level));
  return pose(
    matrix[3], matrix[7], matrix[11], yaw / RADIANS, pitch / RADIANS, roll / RADIANS,
  );
}

/** Turned to the right and up, never beyond the vertical. */
export function turned(head, yaw, pitch) {
  const most = Math.max(STEEPEST_DEG, Math.abs(head.pitch));
  const lifted = Math.min(Math.max(head.pitch + pitch, -most), most);
  return pose(head.x, head.y, head.z, head.yaw + yaw, lifted, head.roll);
}

/** Moved ahead and to the right as the head is turned, and up in the world. */
export function moved(head, ahead, right, up) {
  const m = matrixOf(head);
  return pose(
    head.x + m[0] * right - m[2] * ahead,
    head.y + m[4] * right - m[6] * ahead + up,
    head.z + m[8] * right - m[10] * ahead,
    head.yaw, head.pitch, head.roll,
  );
}
