// The time line: steps of the walk over the graph, planted intervals of both feet, and the place being played. A native slider
// lies over the drawing, so that keyboard, mouse, touch and screen readers all work it.
import type { Report } from './api_client';
import { html, onWidth, spoken, svg } from './dom';
import type { Player } from './player';
import { LEFT_PX, Playhead, RIGHT_PX, TimeAxis, scrubbable } from './time_axis';

const STEP_ROW = { y: 2, height: 22 };
const FOOT_ROWS = { left: { y: 30, height: 12 }, right: { y: 46, height: 12 } };
const AXIS_Y = 62;
const HEIGHT = 80;

export class Timeline {
  private readonly drawing = svg('svg', { class: 'timeline-drawing', 'aria-hidden': 'true', height: HEIGHT });
  private readonly slider = html('input', { type: 'range', id: 'scrub', min: 0, step: 1, value: 0, 'aria-label': 'Place in the clip' });
  private readonly head = new Playhead();
  private stepBoxes: SVGElement[] = [];
  private litBox?: SVGElement;
  private axis = new TimeAxis(600, 1);
  private report?: Report;

  constructor(host: HTMLElement, private readonly player: Player) {
    host.append(this.drawing, this.head.element, this.slider);
    onWidth(host, (width) => {
      this.axis = new TimeAxis(width, player.duration);
      this.draw();
    });
    this.slider.addEventListener('input', () => player.seek(Number(this.slider.value) * player.frameTime));
    scrubbable(this.drawing, (x) => player.seek(this.axis.time(x)));
    player.onChange(() => this.follow());
  }

  load(report: Report): void {
    this.report = report;
    this.slider.max = String(this.player.frames - 1);
    this.axis = new TimeAxis(this.axis.width, this.player.duration);
    this.draw();
  }

  private draw(): void {
    const { report, axis, player } = this;
    if (!report) return;
    const x = (frame: number) => axis.x(frame * player.frameTime);
    const rows: SVGElement[] = axis.drawTicks(0, AXIS_Y, true);
    rows.push(svg('text', { x: 4, y: 17, class: 'axis-text' }, 'steps'));
    this.stepBoxes = report.steps.map((step, i) => {
      const width = Math.max(1, x(step.to) - x(step.from) - 1.5);
      const box = svg('g', { class: `step ${i % 2 ? 'odd' : 'even'}` },
        svg('title', {}, `${spoken(step.primitive)}, frames ${step.from} to ${step.to}`),
        svg('rect', { x: x(step.from), y: STEP_ROW.y, width, height: STEP_ROW.height, rx: 4 }));
      const label = fitted(spoken(step.primitive), width);
      if (label) {
        box.append(svg('text', { x: x(step.from) + width / 2, y: STEP_ROW.y + 15, 'text-anchor': 'middle' }, label));
      }
      return box;
    });
    rows.push(...this.stepBoxes);
    for (const foot of ['left', 'right'] as const) {
      const { y, height } = FOOT_ROWS[foot];
      rows.push(svg('rect', { x: LEFT_PX, y, width: axis.width - LEFT_PX - RIGHT_PX, height, rx: 3, class: 'foot-row' }));
      rows.push(svg('text', { x: 4, y: y + 10, class: `axis-text ${foot}-text` }, foot));
      for (const contact of report.contacts) {
        if (contact.foot !== foot) continue;
        const width = Math.max(2, x(contact.to) - x(contact.from));
        rows.push(svg('rect', { x: x(contact.from), y, width, height, rx: 3, class: `${foot}-fill` },
          svg('title', {}, `${foot} foot planted, frames ${contact.from} to ${contact.to}`)));
      }
    }
    this.drawing.replaceChildren(...rows);
    this.drawing.setAttribute('width', String(axis.width));
    this.follow();
  }

  private follow(): void {
    const { player, axis } = this;
    this.head.move(axis.x(player.time));
    this.slider.value = String(player.frame);
    const step = currentStep(this.report, player.frame);
    const name = step < 0 ? '' : `, ${spoken(this.report!.steps[step].primitive)}`;
    this.slider.setAttribute('aria-valuetext', `${player.time.toFixed(2)} of ${player.duration.toFixed(2)} seconds${name}`);
    if (this.litBox === this.stepBoxes[step]) return;
    this.litBox?.classList.remove('current');
    this.litBox = this.stepBoxes[step];
    this.litBox?.classList.add('current');
  }
}

/** Index of the step that a frame belongs to; -1 before the first. */
export function currentStep(report: Report | undefined, frame: number): number {
  let found = -1;
  report?.steps.forEach((step, i) => {
    if (step.from <= frame) found = i;
  });
  return found;
}

/** A step's name as it fits a box: whole, its initials, or nothing. */
function fitted(name: string, width: number): string {
  if (width > name.length * 6.2 + 8) return name;
  const initials = name.split(' ').map((word) => word[0].toUpperCase()).join('');
  return width > initials.length * 8 + 4 ? initials : '';
}
