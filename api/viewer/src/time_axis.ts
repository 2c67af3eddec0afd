// The horizontal axis that the time line and all curves share, so that one moment stands at one place in all of them.
import { html, svg } from './dom';

export const LEFT_PX = 46;
export const RIGHT_PX = 12;

export class TimeAxis {
  constructor(readonly width: number, readonly duration: number) {}

  x(time: number): number {
    return LEFT_PX + (time / Math.max(this.duration, 1e-9)) * (this.width - LEFT_PX - RIGHT_PX);
  }

  time(x: number): number {
    const part = (x - LEFT_PX) / (this.width - LEFT_PX - RIGHT_PX);
    return Math.min(Math.max(part, 0), 1) * this.duration;
  }

  /** Round times for ticks, some 80 pixels apart or more. */
  ticks(): number[] {
    const wanted = Math.max(2, (this.width - LEFT_PX) / 80);
    const step = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120].find((s) => this.duration / s <= wanted) ?? 300;
    return Array.from({ length: Math.floor(this.duration / step + 1e-6) + 1 }, (_, i) => i * step);
  }

  /** Tick labels, with lines from `top` to `bottom`. */
  drawTicks(top: number, bottom: number, labelled: boolean): SVGElement[] {
    const label = (time: number) => String(Number(time.toFixed(1))) + (time === 0 ? ' s' : '');
    return this.ticks().flatMap((time) => {
      const x = this.x(time);
      const line = svg('line', { x1: x, x2: x, y1: top, y2: bottom, class: 'tick' });
      return labelled ? [line, svg('text', { x, y: bottom + 13, class: 'axis-text', 'text-anchor': 'middle' }, label(time))] : [line];
    });
  }
}

/**
 * The line at the moment being played. It lies over a drawing, not in it: moving a part of an SVG would paint all of it anew
 * for each frame, and the drawings of long clips have thousands of parts.
 */
export class Playhead {
  readonly element = html('div', { class: 'playhead', 'aria-hidden': 'true' });

  move(x: number): void {
    this.element.style.transform = `translateX(${x.toFixed(1)}px)`;
  }
}

/** Lets a drawing be scrubbed with mouse or finger. */
export function scrubbable(element: Element, seek: (x: number) => void): void {
  const move = (event: PointerEvent) => seek(event.clientX - element.getBoundingClientRect().left);
  element.addEventListener('pointerdown', (event) => {
    const pointer = event as PointerEvent;
    element.setPointerCapture(pointer.pointerId);
    move(pointer);
  });
  element.addEventListener('pointermove', (event) => {
    if (element.hasPointerCapture((event as PointerEvent).pointerId)) move(event as PointerEvent);
  });
}
