// The report's numbers, each with its unit and a line that says what it measures.
import type { Report } from './api_client';
import { html } from './dom';

interface Figure { name: string; value: string; unit: string; meaning: string }

function figuresOf(report: Report): Figure[] {
  const { quality } = report;
  const length = report.path.slice(1).reduce((sum, [x, z], i) => sum + Math.hypot(x - report.path[i][0], z - report.path[i][1]), 0);
  const figures: Figure[] = [
    { name: 'Contact distance', value: (quality.contact_distance * 1000).toFixed(1), unit: 'mm', meaning: 'mean height error of planted feet' },
    { name: 'Foot skate', value: quality.foot_skate_cm_s.toFixed(2), unit: 'cm/s', meaning: 'sliding of feet near the floor' },
    { name: 'Penetration', value: (quality.penetration * 1000).toFixed(1), unit: 'mm', meaning: 'deepest point below the floor' },
    { name: 'Naturalness', ...scientific(quality.naturalness, 'm⁴'), meaning: 'variance of the frame difference' },
    { name: 'Distance', value: length.toFixed(2), unit: 'm', meaning: 'walked by the root' },
    { name: 'Mean speed', value: (length / Math.max(report.duration, 1e-9)).toFixed(2), unit: 'm/s', meaning: 'of the root over the clip' },
  ];
  if (typeof quality.log_likelihood === 'number') {
    figures.push({ name: 'Log-likelihood', value: quality.log_likelihood.toFixed(1), unit: 'nats', meaning: 'of the clip under the model' });
  }
  return figures;
}

function scientific(value: number, unit: string): { value: string; unit: string } {
  if (!(value > 0)) return { value: String(value), unit };
  const power = Math.floor(Math.log10(value));
  return { value: (value / 10 ** power).toFixed(2), unit: `×10${superscript(power)} ${unit}` };
}

function superscript(power: number): string {
  return String(power).replace('-', '⁻').replace(/\d/g, (digit) => '⁰¹²³⁴⁵⁶⁷⁸⁹'[Number(digit)]);
}

export function showQuality(host: HTMLElement, report: Report): void {
  host.replaceChildren(...figuresOf(report).map(({ name, value, unit, meaning }) =>
    html('div', { class: 'figure-card' },
      html('dt', {}, name),
      html('dd', {}, html('span', { class: 'number' }, value), ` ${unit}`, html('small', {}, meaning)))));
}
