// Curves of a clip, measured on the joints that are shown: one value a frame.
import { Vector3 } from 'three';
import type { ClipMotion } from './clip_motion';
import type { Role } from './joint_roles';

export interface Series { name: string; unit: string; style: string; values: Float32Array; digits: number }
export interface Chart { title: string; series: Series[]; shadeContacts: boolean }

/** Speed of the root over the floor, m/s, by central differences. */
function rootSpeed(motion: ClipMotion): Float32Array {
  const hips = motion.roles.get('hips') ?? 0;
  const a = new Vector3();
  const b = new Vector3();
  return Float32Array.from({ length: motion.frames }, (_, frame) => {
    const from = Math.max(0, frame - 1);
    const to = Math.min(motion.frames - 1, frame + 1);
    motion.position(from, hips, a);
    motion.position(to, hips, b);
    return Math.hypot(b.x - a.x, b.z - a.z) / Math.max((to - from) * motion.frameTime, 1e-9);
  });
}

function height(motion: ClipMotion, role: Role): Float32Array | undefined {
  const joint = motion.roles.get(role);
  if (joint === undefined) return undefined;
  return Float32Array.from({ length: motion.frames }, (_, frame) => motion.positions[(frame * motion.bones.length + joint) * 3 + 1] * 100);
}

/**
 * How much the pose changes from a frame to the next: root mean square distance of the joints, cm, after the best turn about
 * the vertical and shift on the floor (closed form of Kovar et al. 2002, all joints alike). The last frame repeats its
 * neighbour, so that there is one value a frame.
 */
function frameDifference(motion: ClipMotion): Float32Array {
  const count = motion.bones.length;
  const p = motion.positions;
  const values = new Float32Array(motion.frames);
  for (let frame = 0; frame + 1 < motion.frames; ++frame) {
    const a = frame * count * 3;
    const b = a + count * 3;
    let ax = 0, az = 0, bx = 0, bz = 0;
    for (let j = 0; j < count; ++j) {
      ax += p[a + 3 * j] / count;
      az += p[a + 3 * j + 2] / count;
      bx += p[b + 3 * j] / count;
      bz += p[b + 3 * j + 2] / count;
    }
    let along = 0, across = 0, spread = 0, vertical = 0;
    for (let j = 0; j < count; ++j) {
      const x0 = p[a + 3 * j] - ax, z0 = p[a + 3 * j + 2] - az;
      const x1 = p[b + 3 * j] - bx, z1 = p[b + 3 * j + 2] - bz;
      along += x0 * x1 + z0 * z1;
      across += x0 * z1 - z0 * x1;
      spread += x0 * x0 + z0 * z0 + x1 * x1 + z1 * z1;
      vertical += (p[a + 3 * j + 1] - p[b + 3 * j + 1]) ** 2;
    }
    const squared = Math.max(0, spread - 2 * Math.hypot(along, across)) + vertical;
    values[frame] = Math.sqrt(squared / count) * 100;
  }
  if (motion.frames > 1) values[motion.frames - 1] = values[motion.frames - 2];
  return values;
}

export function chartsOf(motion: ClipMotion): Chart[] {
  const heights: Series[] = [];
  for (const foot of ['left', 'right'] as const) {
    for (const [role, part, dash] of [['toe', 'ball', ''], ['ankle', 'ankle', ' dashed']] as const) {
      const values = height(motion, `${foot}_${role}`);
      if (values) heights.push({ name: `${foot} ${part}`, unit: 'cm', style: `${foot}-line${dash}`, values, digits: 1 });
    }
  }
  return [
    { title: 'Root speed', shadeContacts: false,
      series: [{ name: 'root', unit: 'm/s', style: 'root-line', values: rootSpeed(motion), digits: 2 }] },
    { title: 'Height of the feet', shadeContacts: true, series: heights },
    { title: 'Frame difference', shadeContacts: false,
      series: [{ name: 'to the next frame', unit: 'cm', style: 'difference-line', values: frameDifference(motion), digits: 2 }] },
  ];
}
