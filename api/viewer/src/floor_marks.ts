// What the walk leaves on the floor: the path of the root, and a print where each foot was planted.
import {
  BufferAttribute, BufferGeometry, Color, DoubleSide, Group, Mesh, MeshBasicMaterial, Shape, ShapeGeometry, Vector3,
} from 'three';
import type { Contact } from './api_client';
import type { ClipMotion } from './clip_motion';
import { themeColour } from './theme';

const PATH_WIDTH_M = 0.022;
const SIGHT_M = 16;
const LIFT_M = 0.004; // above the ground, so that the two never fight for a pixel

export class FloorMarks {
  readonly object = new Group();
  private readonly whole: Mesh<BufferGeometry, MeshBasicMaterial>;
  private readonly walked: Mesh<BufferGeometry, MeshBasicMaterial>;
  private readonly prints: { contact: Contact; mesh: Mesh<ShapeGeometry, MeshBasicMaterial> }[];

  constructor(motion: ClipMotion, path: [number, number][], contacts: Contact[]) {
    const ribbon = ribbonAlong(path);
    this.whole = new Mesh(ribbon, flat(0.3));
    this.walked = new Mesh(ribbon.clone(), flat(0.95));
    this.walked.position.y = 0.001;
    this.prints = contacts.map((contact) => {
      const mesh = new Mesh(PRINT, flat(1));
      mesh.position.set(contact.position[0], LIFT_M + 0.002, contact.position[1]);
      mesh.rotation.set(0, headingOf(motion, contact), 0);
      return { contact, mesh };
    });
    this.object.add(this.whole, this.walked, ...this.prints.map(({ mesh }) => mesh));
    this.recolour();
  }

  recolour(): void {
    this.whole.material.color.set(themeColour('--path'));
    this.walked.material.color.set(themeColour('--path'));
    for (const { contact, mesh } of this.prints) mesh.material.color = new Color(themeColour(`--${contact.foot}`));
  }

  /**
   * Shows the state at a frame: prints to come are faint, one being stood on is full. Prints out of sight of the figure, at x and
   * z, are left out: a clip of ten minutes has thousands.
   */
  show(frame: number, x: number, z: number): void {
    this.walked.geometry.setDrawRange(0, Math.max(0, frame) * 6);
    for (const { contact, mesh } of this.prints) {
      mesh.visible = Math.hypot(contact.position[0] - x, contact.position[1] - z) < SIGHT_M;
      mesh.material.opacity = frame < contact.from ? 0.14 : frame <= contact.to ? 1 : 0.5;
    }
  }

  dispose(): void {
    for (const mesh of [this.whole, this.walked]) mesh.geometry.dispose();
    for (const mesh of [this.whole, this.walked, ...this.prints.map(({ mesh }) => mesh)]) mesh.material.dispose();
  }
}

function flat(opacity: number): MeshBasicMaterial {
  return new MeshBasicMaterial({ transparent: true, opacity, side: DoubleSide, depthWrite: false });
}

/** Where the foot points in the middle of a contact: the turn about Y that takes +Z there. */
function headingOf(motion: ClipMotion, contact: Contact): number {
  const ankle = motion.roles.get(`${contact.foot}_ankle`);
  const toe = motion.roles.get(`${contact.foot}_toe`);
  if (ankle === undefined || toe === undefined) return 0;
  const frame = Math.min(motion.frames - 1, Math.round((contact.from + contact.to) / 2));
  const along = motion.position(frame, toe, new Vector3()).sub(motion.position(frame, ankle));
  return Math.atan2(along.x, along.z);
}

function ribbonAlong(path: [number, number][]): BufferGeometry {
  const points = new Float32Array(path.length * 6);
  const index: number[] = [];
  let across: [number, number] = [1, 0];
  path.forEach(([x, z], i) => {
    const [fromX, fromZ] = path[Math.max(0, i - 2)];
    const [toX, toZ] = path[Math.min(path.length - 1, i + 2)];
    const length = Math.hypot(toX - fromX, toZ - fromZ);
    if (length > 1e-4) across = [((toZ - fromZ) / length) * PATH_WIDTH_M, (-(toX - fromX) / length) * PATH_WIDTH_M];
    points.set([x - across[0] / 2, LIFT_M, z - across[1] / 2, x + across[0] / 2, LIFT_M, z + across[1] / 2], i * 6);
    if (i > 0) index.push(2 * i - 2, 2 * i - 1, 2 * i, 2 * i, 2 * i - 1, 2 * i + 1);
  });
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(points, 3));
  geometry.setIndex(index);
  return geometry;
}

/** A sole, toes towards +Z, the ball of the foot at the origin. */
const PRINT = (() => {
  const sole = new Shape();
  sole.moveTo(-0.028, -0.17);
  sole.bezierCurveTo(-0.034, -0.1, -0.03, -0.07, -0.044, -0.01);
  sole.bezierCurveTo(-0.052, 0.05, -0.03, 0.085, 0, 0.085);
  sole.bezierCurveTo(0.03, 0.085, 0.052, 0.05, 0.044, -0.01);
  sole.bezierCurveTo(0.03, -0.07, 0.034, -0.1, 0.028, -0.17);
  sole.bezierCurveTo(0.022, -0.205, -0.022, -0.205, -0.028, -0.17);
  return new ShapeGeometry(sole, 10).rotateX(Math.PI / 2);
})();
