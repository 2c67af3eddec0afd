// What has been drawn on the floor, and the part of a clip request that it stands for.
import type { ClipRequest } from './api_client';

export type Place = [x: number, z: number];
export type Hand = 'left_wrist' | 'right_wrist';

export type Control =
  | { kind: 'path'; points: Place[] }
  | { kind: 'goal'; position: Place; heading?: number }
  | { kind: 'hand'; joint: Hand; place: Place; height: number; time: number }
  | { kind: 'keep_out'; center: Place; radius: number };

export type Kind = Control['kind'];

/** There is one path and one goal; hand targets and keep-out circles may be many. */
export class Controls {
  list: Control[] = [];
  private readonly listeners: (() => void)[] = [];

  onChange(listener: () => void): void {
    this.listeners.push(listener);
  }

  add(control: Control): void {
    const single = control.kind === 'path' || control.kind === 'goal';
    if (single) this.list = this.list.filter(({ kind }) => kind !== control.kind);
    this.list.push(control);
    this.changed();
  }

  remove(control: Control): void {
    this.list = this.list.filter((other) => other !== control);
    this.changed();
  }

  clear(): void {
    this.list = [];
    this.changed();
  }

  /** To be called after a control was altered in place. */
  changed(): void {
    for (const listener of this.listeners) listener();
  }

  /** Whether there is a way to go, so that a clip may last as long as it takes. */
  get hasWay(): boolean {
    return this.list.some(({ kind }) => kind === 'path' || kind === 'goal');
  }

  /** The fields of a request that stand for all this. */
  fields(): Pick<ClipRequest, 'path' | 'goal' | 'constraints'> {
    const fields: ReturnType<Controls['fields']> = {};
    for (const control of this.list) {
      if (control.kind === 'path') fields.path = { points: control.points, interpolation: 'spline' };
      if (control.kind === 'goal') fields.goal = { position: control.position, ...(control.heading === undefined ? {} : { heading: control.heading }) };
    }
    const constraints = this.constrained().map((control) => control.kind === 'hand'
      ? { type: 'position', joint: control.joint, time: control.time, value: [control.place[0], control.height, control.place[1]] }
      : { type: 'keep_out', circle: { center: control.center, radius: control.radius } });
    return constraints.length > 0 ? { ...fields, constraints } : fields;
  }

  /** The control that a pointer into the request leads to. */
  at(pointer: string): Control | undefined {
    const [, field, index] = pointer.split('/');
    if (field === 'constraints') return this.constrained()[Number(index)];
    return this.list.find(({ kind }) => kind === field);
  }

  toText(): string {
    return JSON.stringify(this.list);
  }

  /** Takes what toText() gave; anything else is left out. */
  readText(text: string): void {
    try {
      const read: unknown = JSON.parse(text);
      this.list = (Array.isArray(read) ? read : []).filter(isControl);
    } catch {
      this.list = [];
    }
  }

  private constrained(): Extract<Control, { kind: 'hand' | 'keep_out' }>[] {
    return this.list.filter((control) => control.kind === 'hand' || control.kind === 'keep_out');
  }
}

const isPlace = (value: unknown): value is Place => Array.isArray(value) && value.length === 2 && value.every(Number.isFinite);

function isControl(value: Control | null): value is Control {
  switch (value?.kind) {
    case 'path': return Array.isArray(value.points) && value.points.length >= 2 && value.points.every(isPlace);
    case 'goal': return isPlace(value.position) && (value.heading === undefined || Number.isFinite(value.heading));
    case 'hand': return isPlace(value.place) && Number.isFinite(value.height) && Number.isFinite(value.time) && /^(left|right)_wrist$/.test(value.joint);
    case 'keep_out': return isPlace(value.center) && Number.isFinite(value.radius);
    default: return false;
  }
}
