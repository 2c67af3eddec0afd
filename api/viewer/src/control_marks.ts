// Shows on the stage what was drawn: the path, the goal with its heading, hand targets on their poles, areas that are kept out of.
import {
  BufferGeometry, CatmullRomCurve3, CircleGeometry, ConeGeometry, CylinderGeometry, DoubleSide, Group, Line, LineBasicMaterial, Material, Mesh,
  MeshBasicMaterial, Object3D, RingGeometry, SphereGeometry, Vector3,
} from 'three';
import type { Control, Place } from './controls';
import { themeColour } from './theme';

const LIFT_M = 0.012; // above the clip's own marks

const at = ([x, z]: Place, height = LIFT_M): Vector3 => new Vector3(x, height, z);

function flat(colour: string, opacity: number): MeshBasicMaterial {
  return new MeshBasicMaterial({ color: themeColour(colour), transparent: true, opacity, side: DoubleSide, depthWrite: false });
}

function disc(centre: Place, radius: number, material: Material, inner = 0): Mesh {
  const shape = inner > 0 ? new RingGeometry(inner, radius, 48) : new CircleGeometry(radius, 48);
  const mesh = new Mesh(shape.rotateX(-Math.PI / 2), material);
  mesh.position.copy(at(centre));
  return mesh;
}

function marksOf(control: Control): Object3D[] {
  switch (control.kind) {
    case 'path': {
      const points = control.points.map((point) => at(point));
      const curve = new CatmullRomCurve3(points, false, 'centripetal');
      const line = new Line(new BufferGeometry().setFromPoints(curve.getPoints(points.length * 8)), new LineBasicMaterial({ color: themeColour('--asked') }));
      return [line, ...control.points.map((point) => disc(point, 0.035, flat('--asked', 0.9))), disc(control.points[0], 0.09, flat('--asked', 0.9), 0.065)];
    }
    case 'goal': {
      const marks: Object3D[] = [disc(control.position, 0.14, flat('--asked', 0.9), 0.1), disc(control.position, 0.04, flat('--asked', 0.9))];
      if (control.heading !== undefined) {
        const turn = control.heading * Math.PI / 180;
        const arrow = new Mesh(new ConeGeometry(0.07, 0.3, 16).rotateX(Math.PI / 2), flat('--asked', 0.9));
        arrow.position.copy(at(control.position)).add(new Vector3(Math.sin(turn), 0.04, Math.cos(turn)).multiplyScalar(0.32));
        arrow.rotation.y = turn;
        marks.push(arrow);
      }
      return marks;
    }
    case 'hand': {
      const pole = new Mesh(new CylinderGeometry(0.006, 0.006, control.height), flat('--asked', 0.6));
      pole.position.copy(at(control.place, control.height / 2));
      const ball = new Mesh(new SphereGeometry(0.05, 20, 14), new MeshBasicMaterial({ color: themeColour(control.joint === 'left_wrist' ? '--left' : '--right') }));
      ball.position.copy(at(control.place, control.height));
      return [pole, ball, disc(control.place, 0.05, flat('--asked', 0.6))];
    }
    case 'keep_out':
      return [disc(control.center, control.radius, flat('--bad', 0.25)), disc(control.center, control.radius, flat('--bad', 0.9), Math.max(control.radius - 0.02, 0.001))];
  }
}

export class ControlMarks {
  readonly object = new Group();

  /** Shows these controls in place of the last ones. */
  show(controls: Control[]): void {
    this.object.traverse((part) => {
      if (!(part instanceof Mesh || part instanceof Line)) return;
      part.geometry.dispose();
      (part.material as Material).dispose();
    });
    this.object.clear();
    for (const control of controls) this.object.add(...marksOf(control));
  }
}
