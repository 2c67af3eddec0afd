// The variants of a request as thin figures that walk along, and the floor that all of them together pass over.
import { BufferAttribute, BufferGeometry, Group, LineBasicMaterial, LineLoop, LineSegments, Vector3 } from 'three';
import type { VariantSummary } from './api_client';
import type { ClipMotion } from './clip_motion';
import { themeColour } from './theme';

interface Ghost { motion: ClipMotion; joints: [joint: number, parent: number][]; lines: LineSegments<BufferGeometry, LineBasicMaterial> }

export class Ghosts {
  readonly object = new Group();
  private ghosts: Ghost[] = [];
  private readonly material = new LineBasicMaterial({ transparent: true, opacity: 0.55 });
  private readonly rim = new LineBasicMaterial({ transparent: true, opacity: 0.9 });

  get count(): number {
    return this.ghosts.length;
  }

  add(motion: ClipMotion): void {
    // A root that only places the body is no bone of it.
    const joints = motion.parents.flatMap((parent, joint): [number, number][] => (parent >= 0 && isPartOfBody(motion, parent) ? [[joint, parent]] : []));
    const geometry = new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(joints.length * 6), 3));
    const lines = new LineSegments(geometry, this.material);
    lines.frustumCulled = false;
    this.ghosts.push({ motion, joints, lines });
    this.object.add(lines);
    this.recolour();
  }

  showArea(area: VariantSummary['swept_area']): void {
    for (const { outline, holes } of area.polygons) {
      for (const ring of [outline, ...holes]) {
        const points = ring.map(([x, z]) => new Vector3(x, 0.008, z));
        this.object.add(new LineLoop(new BufferGeometry().setFromPoints(points), this.rim));
      }
    }
    this.recolour();
  }

  /** Poses all of them at a time from the start; those that have ended stay where they are. */
  pose(seconds: number): void {
    const point = new Vector3();
    for (const { motion, joints, lines } of this.ghosts) {
      const frame = Math.min(Math.max(Math.round(seconds / motion.frameTime), 0), motion.frames - 1);
      const places = lines.geometry.attributes.position as BufferAttribute;
      joints.forEach(([joint, parent], i) => {
        motion.position(frame, parent, point).toArray(places.array, i * 6);
        motion.position(frame, joint, point).toArray(places.array, i * 6 + 3);
      });
      places.needsUpdate = true;
    }
  }

  recolour(): void {
    this.material.color.set(themeColour('--ghost'));
    this.rim.color.set(themeColour('--asked'));
  }

  clear(): void {
    for (const part of this.object.children) (part as LineSegments).geometry.dispose();
    this.object.clear();
    this.ghosts = [];
  }
}

function isPartOfBody(motion: ClipMotion, joint: number): boolean {
  const hips = motion.roles.get('hips') ?? 0;
  for (let j = joint; j >= 0; j = motion.parents[j]) {
    if (j === hips) return true;
  }
  return false;
}
