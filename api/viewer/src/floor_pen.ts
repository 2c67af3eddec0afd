// Drawing on the floor with mouse, finger or pen: a press, a drag and a release become a control.
import type { Control, Kind, Place } from './controls';
import type { Stage } from './stage';

const PATH_STEP_M = 0.3; // between points of a drawn path; a spline joins them
const TURN_M = 0.15; // a drag shorter than this is a click: no heading
const CIRCLE_M = 0.4; // radius of a keep-out circle that was only clicked

const round = (metres: number): number => Math.round(metres * 100) / 100;
const distance = (a: Place, b: Place): number => Math.hypot(b[0] - a[0], b[1] - a[1]);

/** What a stroke over the floor makes; undefined where it is too short to make anything. `time` is that of a hand target. */
export function controlFrom(kind: Kind, stroke: Place[], time: number): Control | undefined {
  const first = stroke[0];
  const last = stroke[stroke.length - 1];
  switch (kind) {
    case 'path': {
      const points: Place[] = [first];
      for (const place of stroke) {
        if (distance(points[points.length - 1], place) >= PATH_STEP_M) points.push(place);
      }
      if (distance(points[points.length - 1], last) > PATH_STEP_M / 2) points.push(last);
      return points.length < 2 ? undefined : { kind, points };
    }
    case 'goal': {
      const heading = Math.round(Math.atan2(last[0] - first[0], last[1] - first[1]) * 180 / Math.PI);
      return { kind, position: first, ...(distance(first, last) > TURN_M ? { heading } : {}) };
    }
    case 'hand': return { kind, joint: 'right_wrist', place: last, height: 1.2, time };
    case 'keep_out': {
      const radius = round(distance(first, last));
      return { kind, center: first, radius: radius > TURN_M ? radius : CIRCLE_M };
    }
  }
}

export class FloorPen {
  private kind?: Kind;
  private stroke: Place[] = [];

  /** `onStroke` is called while a control is drawn (undefined: no more), `onDone` with what was drawn. `time` says that of a new hand target. */
  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly stage: Stage,
    private readonly time: () => number,
    private readonly onStroke: (control: Control | undefined) => void,
    private readonly onDone: (control: Control) => void,
  ) {
    canvas.addEventListener('pointerdown', (event) => this.begin(event));
    canvas.addEventListener('pointermove', (event) => this.move(event));
    canvas.addEventListener('pointerup', () => this.end());
    canvas.addEventListener('pointercancel', () => this.drop());
  }

  /** Takes up the pen for one kind of control; undefined lays it down, and the canvas turns the camera again. */
  take(kind: Kind | undefined): void {
    this.drop();
    this.kind = kind;
    this.stage.orbits = !kind;
    this.canvas.classList.toggle('drawing', Boolean(kind));
  }

  private begin(event: PointerEvent): void {
    const place = this.placeOf(event);
    if (!this.kind || !place || event.button !== 0) return;
    this.canvas.setPointerCapture(event.pointerId);
    this.stroke = [place];
    this.show();
  }

  private move(event: PointerEvent): void {
    const place = this.placeOf(event);
    if (this.stroke.length === 0 || !place) return;
    this.stroke.push(place);
    this.show();
  }

  private end(): void {
    const control = this.drawn();
    this.drop();
    if (control) this.onDone(control);
  }

  private drop(): void {
    this.stroke = [];
    this.onStroke(undefined);
  }

  private show(): void {
    this.onStroke(this.drawn());
  }

  private drawn(): Control | undefined {
    return this.kind && this.stroke.length > 0 ? controlFrom(this.kind, this.stroke, this.time()) : undefined;
  }

  private placeOf(event: PointerEvent): Place | undefined {
    const place = this.stage.floorAt(event.clientX, event.clientY);
    return place && [round(place[0]), round(place[1])];
  }
}
