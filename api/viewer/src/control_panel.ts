// The panel that says where to go: pens to draw with, the list of what was drawn, and beside each what the server found wrong with it.
import type { ApiError, ConstraintOutcome } from './api_client';
import type { Control, Controls, Hand, Kind } from './controls';
import { byId, html, spoken } from './dom';

const HINTS: Record<Kind, string> = {
  path: 'Drag over the floor.',
  goal: 'Click where the walk ends; drag to say where to face.',
  hand: 'Click where the hand shall be.',
  keep_out: 'Click the middle and drag to the rim.',
};

const metres = (value: number): string => `${value.toFixed(1)} m`;

function describe(control: Control): string {
  switch (control.kind) {
    case 'path': return `Path of ${metres(control.points.reduce((sum, [x, z], i) => sum + (i ? Math.hypot(x - control.points[i - 1][0], z - control.points[i - 1][1]) : 0), 0))}`;
    case 'goal': return `Goal at ${control.position.map((c) => c.toFixed(1)).join(', ')}${control.heading === undefined ? '' : `, facing ${control.heading}°`}`;
    case 'hand': return 'Hand';
    case 'keep_out': return `Keep out, ${metres(control.radius)} around ${control.center.map((c) => c.toFixed(1)).join(', ')}`;
  }
}

function outcomeText(control: Control, { pointer, met, residual, unit }: ConstraintOutcome): string {
  if (control.kind === 'keep_out') return met ? 'not entered' : `entered by ${(residual * 100).toFixed(1)} cm`;
  const part = control.kind === 'hand' ? '' : pointer.split('/').slice(2).join(' '); // "heading" of a goal
  const off = unit === 'm' ? `${(residual * 100).toFixed(1)} cm off` : `${residual.toFixed(1)} ${unit === 'deg' ? '°' : unit} off`;
  return part ? `${spoken(part)}: ${off}` : off;
}

export class ControlPanel {
  private readonly list = byId('controls');
  private readonly rows = new Map<Control, HTMLElement>();
  private pen?: Kind;

  /** `onPen` is called when a pen is taken up or laid down. */
  constructor(private readonly controls: Controls, private readonly onPen: (kind: Kind | undefined) => void) {
    for (const button of this.pens()) {
      button.addEventListener('click', () => this.takePen(this.pen === button.dataset.pen ? undefined : (button.dataset.pen as Kind)));
    }
    byId('clear-controls').addEventListener('click', () => controls.clear());
    controls.onChange(() => this.update());
    this.update();
  }

  takePen(kind: Kind | undefined): void {
    this.pen = kind;
    for (const button of this.pens()) button.setAttribute('aria-pressed', String(button.dataset.pen === kind));
    byId('pen-hint').textContent = kind ? HINTS[kind] : '';
    this.onPen(kind);
  }

  /** Says beside each control what is wrong with it. */
  markErrors(error: ApiError): void {
    for (const { pointer, detail } of error.errors) {
      const control = this.controls.at(pointer);
      if (control) this.rows.get(control)?.append(html('p', { class: 'field-error' }, detail));
    }
  }

  /** Says beside each control how nearly it was met. */
  showOutcomes(outcomes: ConstraintOutcome[]): void {
    for (const note of this.list.querySelectorAll('.outcome, .field-error')) note.remove();
    for (const outcome of outcomes) {
      const control = this.controls.at(outcome.pointer);
      if (control) this.rows.get(control)?.append(html('span', { class: outcome.met ? 'outcome' : 'outcome unmet' }, outcomeText(control, outcome)));
    }
  }

  private pens(): HTMLButtonElement[] {
    return [...document.querySelectorAll<HTMLButtonElement>('[data-pen]')];
  }

  /** Rows stay as long as what they stand for: a field in one may be in use. */
  private update(): void {
    const before = new Map(this.rows);
    this.rows.clear();
    for (const control of this.controls.list) this.rows.set(control, before.get(control) ?? this.rowOf(control));
    for (const [control, row] of before) {
      if (!this.rows.has(control)) row.remove();
    }
    this.list.append(...[...this.rows.values()].filter((row) => !row.isConnected));
    byId('clear-controls').hidden = this.controls.list.length === 0;
    byId('no-controls').hidden = this.controls.list.length > 0;
  }

  private rowOf(control: Control): HTMLElement {
    const remove = html('button', { type: 'button', class: 'icon-button', 'aria-label': `Remove: ${describe(control)}` }, '✕');
    remove.addEventListener('click', () => this.controls.remove(control));
    return html('li', { 'data-kind': control.kind }, html('span', { class: 'control-name' }, describe(control)), ...this.fieldsOf(control), remove);
  }

  /** A hand target says which hand, how high, and when. */
  private fieldsOf(control: Control): HTMLElement[] {
    if (control.kind !== 'hand') return [];
    const hand = html('select', { 'aria-label': 'Which hand' }, html('option', { value: 'left_wrist' }, 'left'), html('option', { value: 'right_wrist' }, 'right'));
    hand.value = control.joint;
    hand.addEventListener('change', () => {
      control.joint = hand.value as Hand;
      this.controls.changed();
    });
    const number = (label: string, value: number, step: string, set: (value: number) => void) => {
      const input = html('input', { type: 'number', 'aria-label': label, title: label, value, min: 0, step });
      input.addEventListener('change', () => {
        if (!Number.isFinite(input.valueAsNumber)) return;
        set(input.valueAsNumber);
        this.controls.changed();
      });
      return input;
    };
    return [hand, number('Height, m', control.height, '0.05', (value) => (control.height = value)), html('span', {}, 'm'),
      number('Time, s', control.time, '0.1', (value) => (control.time = value)), html('span', {}, 's')];
  }
}
