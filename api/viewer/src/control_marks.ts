// Shows on the stage what was drawn: the path, the goal with its heading, hand targets on their poles, areas that are kept out of.
import {
  BufferGeometry, CatmullRomCurve3, CircleGeometry, ConeGeometry, CylinderGeometry, DoubleSide, Group, Line, LineBasicMaterial, Material, Mesh,
  MeshBasicMaterial, Object3D, RingGeometry, SphereGeometry, Vector3,
} from 'three';
import type { Control, Place } from './controls';
import { themeColour } from './theme';

const LIFT_M = 0.012; // above the clip's own marks

const at = ([x, z]: Place, height = LIFT_M): Vector3 => new Vector3(x, height, z);
const flat = (opacity: number) => new MeshBasicMaterial({ transparent: true, opacity, side: DoubleSide, depthWrite: false });

function disc(centre: Place, radius: number, material: Material, inner = 0): Mesh {
  const shape = inner > 0 ? new RingGeometry(inner, radius, 48) : new CircleGeometry(radius, 48);
  const mesh = new Mesh(shape.rotateX(-Math.PI / 2), material);
  mesh.position.copy(at(centre));
  return mesh;
}

export class ControlMarks {
  readonly object = new Group();
  // Kept for good: with the last material of a kind its shader would go, to be compiled anew while somebody draws.
  private readonly full = flat(0.9);
  private readonly faint = flat(0.6);
  private readonly area = flat(0.25);
  private readonly rim = flat(0.9);
  private readonly line = new LineBasicMaterial();
  private readonly hands = { left_wrist: new MeshBasicMaterial(), right_wrist: new MeshBasicMaterial() };

  constructor() {
    this.recolour();
  }

  recolour(): void {
    for (const material of [this.full, this.faint, this.line]) material.color.set(themeColour('--asked'));
    for (const material of [this.area, this.rim]) material.color.set(themeColour('--bad'));
    this.hands.left_wrist.color.set(themeColour('--left'));
    this.hands.right_wrist.color.set(themeColour('--right'));
  }

  /** Shows these controls in place of the last ones. */
  show(controls: Control[]): void {
    this.object.traverse((part) => {
      if (part instanceof Mesh || part instanceof Line) part.geometry.dispose();
    });
    this.object.clear();
    for (const control of controls) this.object.add(...this.marksOf(control));
  }

  private marksOf(control: Control): Object3D[] {
    switch (control.kind) {
      case 'path': {
        const curve = new CatmullRomCurve3(control.points.map((point) => at(point)), false, 'centripetal');
        const line = new Line(new BufferGeometry().setFromPoints(curve.getPoints(control.points.length * 8)), this.line);
        return [line, ...control.points.map((point) => disc(point, 0.035, this.full)), disc(control.points[0], 0.09, this.full, 0.065)];
      }
      case 'goal': {
        const marks: Object3D[] = [disc(control.position, 0.14, this.full, 0.1), disc(control.position, 0.04, this.full)];
        if (control.heading !== undefined) {
          const turn = control.heading * Math.PI / 180;
          const arrow = new Mesh(new ConeGeometry(0.07, 0.3, 16).rotateX(Math.PI / 2), this.full);
          arrow.position.copy(at(control.position)).add(new Vector3(Math.sin(turn), 0.04, Math.cos(turn)).multiplyScalar(0.32));
          arrow.rotation.y = turn;
          marks.push(arrow);
        }
        return marks;
      }
      case 'hand': {
        const pole = new Mesh(new CylinderGeometry(0.006, 0.006, control.height), this.faint);
        pole.position.copy(at(control.place, control.height / 2));
        const ball = new Mesh(new SphereGeometry(0.05, 20, 14), this.hands[control.joint]);
        ball.position.copy(at(control.place, control.height));
        return [pole, ball, disc(control.place, 0.05, this.faint)];
      }
      case 'keep_out':
        return [disc(control.center, control.radius, this.area), disc(control.center, control.radius, this.rim, Math.max(control.radius - 0.02, 0.001))];
    }
  }
}
