// Shapes that a figure is made of: tapered capsules, and smooth hulls around spheres.
import { BufferGeometry, LatheGeometry, Quaternion, Vector2, Vector3 } from 'three';
import { ConvexGeometry } from 'three/addons/geometries/ConvexGeometry.js';
import { mergeVertices } from 'three/addons/utils/BufferGeometryUtils.js';

export interface Ball { at: Vector3; radius: number }

const UP = new Vector3(0, 1, 0);
const CAP_STEPS = 6;

/** A capsule from one point to another whose radius changes evenly between its ends. */
export function taperedCapsule(from: Vector3, to: Vector3, radiusFrom: number, radiusTo: number): BufferGeometry {
  const length = from.distanceTo(to);
  const profile: Vector2[] = [];
  for (let i = 0; i <= CAP_STEPS; ++i) {
    const angle = (Math.PI / 2) * (i / CAP_STEPS - 1);
    profile.push(new Vector2(radiusFrom * Math.cos(angle), radiusFrom * Math.sin(angle)));
  }
  for (let i = 0; i <= CAP_STEPS; ++i) {
    const angle = (Math.PI / 2) * (i / CAP_STEPS);
    profile.push(new Vector2(radiusTo * Math.cos(angle), length + radiusTo * Math.sin(angle)));
  }
  const direction = to.clone().sub(from).normalize();
  return new LatheGeometry(profile, 18)
    .applyQuaternion(new Quaternion().setFromUnitVectors(UP, direction))
    .translate(from.x, from.y, from.z);
}

/** The smooth convex hull of spheres and of single points (radius 0). */
export function hull(balls: Ball[]): BufferGeometry {
  const points: Vector3[] = [];
  for (const { at, radius } of balls) {
    if (radius === 0) points.push(at.clone());
    else for (const direction of SPHERE) points.push(at.clone().addScaledVector(direction, radius));
  }
  const faceted = new ConvexGeometry(points);
  faceted.deleteAttribute('normal');
  const smooth = mergeVertices(faceted, 1e-5);
  smooth.computeVertexNormals();
  return smooth;
}

// Directions spread evenly over the sphere (Fibonacci lattice).
const SPHERE = Array.from({ length: 64 }, (_, i) => {
  const y = 1 - (2 * i + 1) / 64;
  const angle = i * Math.PI * (3 - Math.sqrt(5));
  const r = Math.sqrt(1 - y * y);
  return new Vector3(r * Math.cos(angle), y, r * Math.sin(angle));
});
