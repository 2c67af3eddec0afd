// Draws the curves of a clip under the time line, with the values at the place being played.
import type { Contact, EvaluationCurves } from './api_client';
import { chartsOf, evaluationCharts, type Chart } from './curve_series';
import type { ClipMotion } from './clip_motion';
import { html, onWidth, svg } from './dom';
import type { Player } from './player';
import { LEFT_PX, Playhead, RIGHT_PX, TimeAxis, scrubbable } from './time_axis';

const HEIGHT = 108;
const TOP = 8;
const BOTTOM = 90;

export class Curves {
  private plots: Plot[] = [];
  private width = 600;

  constructor(private readonly host: HTMLElement, private readonly player: Player) {
    onWidth(host, (width) => {
      this.width = width;
      for (const plot of this.plots) plot.draw(width);
    });
    player.onChange(() => this.plots.forEach((plot) => plot.follow()));
  }

  load(motion: ClipMotion, contacts: Contact[]): void {
    this.plots = chartsOf(motion).map((chart) => new Plot(chart, contacts, this.player));
    this.host.replaceChildren(...this.plots.map((plot) => plot.element));
    for (const plot of this.plots) plot.draw(this.width);
  }

  /** Says why the server's curves are missing. */
  addNote(text: string): void {
    this.host.append(html('p', { class: 'curves-note' }, text));
  }

  /** Adds what the server measured of the clip that is loaded. */
  add(evaluation: EvaluationCurves, contacts: Contact[]): void {
    for (const chart of evaluationCharts(evaluation)) {
      const plot = new Plot(chart, contacts, this.player);
      this.plots.push(plot);
      this.host.append(plot.element);
      plot.draw(this.width);
    }
  }
}

class Plot {
  readonly element: HTMLElement;
  private readonly drawing = svg('svg', { class: 'plot-drawing', height: HEIGHT, role: 'img' });
  private readonly head = new Playhead();
  private readonly readouts: HTMLElement[];
  private axis = new TimeAxis(600, 1);

  constructor(private readonly chart: Chart, private readonly contacts: Contact[], private readonly player: Player) {
    this.readouts = chart.series.map(() => html('output', { class: 'readout' }));
    const legend = chart.series.map((series, i) =>
      html('span', { class: 'legend-entry' },
        svg('svg', { width: 18, height: 8, 'aria-hidden': 'true' }, svg('line', { x1: 0, x2: 18, y1: 4, y2: 4, class: series.style })),
        `${series.name} `, this.readouts[i]));
    this.element = html('figure', { class: 'plot' },
      html('figcaption', {}, html('span', { class: 'plot-title' }, chart.title), html('span', { class: 'legend' }, ...legend)),
      html('div', { class: 'plot-body' }, this.drawing, this.head.element));
    this.drawing.setAttribute('aria-label', summary(chart));
    scrubbable(this.drawing, (x) => player.seek(this.axis.time(x)));
  }

  draw(width: number): void {
    const { chart, player } = this;
    this.axis = new TimeAxis(width, player.duration);
    const x = (frame: number) => this.axis.x(frame * player.frameTime);
    const all = chart.series.flatMap(({ values }) => [...values]);
    const [low, high, step] = range(all);
    const y = (value: number) => BOTTOM - ((value - low) / (high - low)) * (BOTTOM - TOP);
    const parts: SVGElement[] = [];
    if (chart.shadeContacts) {
      const half = (BOTTOM - TOP) / 2;
      for (const foot of ['left', 'right'] as const) {
        const boxes = this.contacts.filter((contact) => contact.foot === foot).map(({ from, to }) =>
          `M${x(from).toFixed(1)} ${foot === 'left' ? TOP : TOP + half}h${Math.max(1, x(to) - x(from)).toFixed(1)}v${half}H${x(from).toFixed(1)}Z`);
        parts.push(svg('path', { d: boxes.join(''), class: `${foot}-shade` }));
      }
    }
    for (let value = low; value <= high + step / 2; value += step) {
      parts.push(svg('line', { x1: LEFT_PX, x2: width - RIGHT_PX, y1: y(value), y2: y(value), class: 'tick' }));
      parts.push(svg('text', { x: LEFT_PX - 6, y: y(value) + 3.5, 'text-anchor': 'end', class: 'axis-text' }, String(Number(value.toFixed(6)))));
    }
    parts.push(svg('text', { x: 2, y: TOP + 3.5, class: 'axis-text' }, chart.series[0]?.unit ?? ''));
    parts.push(...this.axis.drawTicks(TOP, BOTTOM, true));
    for (const series of chart.series) {
      parts.push(svg('path', { d: path(series.values, (i) => this.axis.x((i / Math.max(series.values.length - 1, 1)) * player.duration), y, width), class: `curve ${series.style}` }));
    }
    this.drawing.replaceChildren(...parts);
    this.drawing.setAttribute('width', String(width));
    this.follow();
  }

  follow(): void {
    this.head.move(this.axis.x(this.player.time));
    this.chart.series.forEach(({ values, digits, unit }, i) => {
      // Curves may have a value more or less than the clip has frames, or another rate.
      const at = Math.round((this.player.time / Math.max(this.player.duration, 1e-9)) * (values.length - 1));
      this.readouts[i].textContent = `${(values[at] ?? 0).toFixed(digits)} ${unit}`;
    });
  }
}

/** Round ends of an axis that holds all values, and the distance of its two to four ticks. */
function range(values: number[]): [low: number, high: number, step: number] {
  let least = 0;
  let most = 1e-6;
  for (const value of values) {
    least = Math.min(least, value);
    most = Math.max(most, value);
  }
  const rough = (most - least) / 3;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5, 10].find((factor) => power * factor >= rough) ?? 10);
  return [Math.floor(least / step + 1e-9) * step, Math.ceil(most / step - 1e-9) * step, step];
}

/** A path through all values; where there are more than pixels, through the lowest and highest of each pixel. */
function path(values: Float32Array, x: (index: number) => number, y: (value: number) => number, width: number): string {
  const group = Math.max(1, Math.floor(values.length / width));
  const points: string[] = [];
  for (let from = 0; from < values.length; from += group) {
    const part = values.subarray(from, from + group);
    const ends = group === 1 ? [part[0]] : [Math.min(...part), Math.max(...part)];
    for (const value of ends) points.push(`${x(from).toFixed(1)} ${y(value).toFixed(1)}`);
  }
  return `M${points.join('L')}`;
}

function summary(chart: Chart): string {
  const spans = chart.series.map(({ name, unit, values, digits }) => {
    const least = values.reduce((a, b) => Math.min(a, b), Infinity);
    const most = values.reduce((a, b) => Math.max(a, b), -Infinity);
    return `${name} ${least.toFixed(digits)} to ${most.toFixed(digits)} ${unit}`;
  });
  return `${chart.title}: ${spans.join(', ')}`;
}
