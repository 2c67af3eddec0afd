// Curves of a clip: those measured here on the joints that are shown, one value a frame, and those that the server measures.
import { Vector3 } from 'three';
import type { EvaluationCurves } from './api_client';
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
  ];
}

/** What the server measures frame by frame with the definitions of its report; spread evenly over the clip. */
export function evaluationCharts(curves: EvaluationCurves): Chart[] {
  const scaled = (values: (number | null)[], factor: number) => Float32Array.from(values, (value) => (value ?? 0) * factor);
  return [
    { title: 'Frame difference', shadeContacts: false,
      series: [{ name: 'to the next frame', unit: 'cm²', style: 'difference-line', values: scaled(curves.frame_difference, 1e4), digits: 2 }] },
    { title: 'Contact distance', shadeContacts: true,
      series: [{ name: 'planted feet', unit: 'mm', style: 'difference-line', values: scaled(curves.contact_distance, 1e3), digits: 1 }] },
  ];
}
