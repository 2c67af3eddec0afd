// Says plainly what the server refused, and why.
import { ApiError } from './api_client';
import { byId, html } from './dom';

const banner = () => byId('problem');

export function showProblem(error: unknown): void {
  const known = error instanceof ApiError ? error : undefined;
  const title = known ? known.title + (known.status ? ` (${known.status})` : '') : 'This did not work';
  const detail = known ? known.detail : error instanceof Error ? error.message : String(error);
  const fields = known?.errors ?? [];
  const close = html('button', { type: 'button', class: 'icon-button', 'aria-label': 'Dismiss' }, '✕');
  close.addEventListener('click', hideProblem);
  banner().replaceChildren(
    html('div', {}, html('strong', {}, title), html('p', {}, detail),
      ...(fields.length > 0 ? [html('ul', {}, ...fields.map(({ pointer, detail }) => html('li', {}, html('code', {}, pointer || '/'), ` ${detail}`)))] : [])),
    close);
  banner().hidden = false;
}

export function hideProblem(): void {
  banner().hidden = true;
  banner().replaceChildren();
}
