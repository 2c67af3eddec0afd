// Asks for variants of the clip that is shown, and says what they have in common.
import { createVariants, type ApiError, type ClipRequest, type VariantSummary } from './api_client';
import { ClipMotion } from './clip_motion';
import type { ClipScene } from './clip_scene';
import { byId } from './dom';

const seconds = ({ min, max }: { min: number; max: number }): string =>
  max - min < 0.05 ? `${min.toFixed(1)} s` : `${min.toFixed(1)} to ${max.toFixed(1)} s`;
const centimetres = (metres: number): string => `${(metres * 100).toFixed(1)} cm`;

/** The summary in words. */
export function summaryText(summary: VariantSummary): string {
  const { asked, made, duration, arrival_time: arrival, path_deviation: path, spread, swept_area: swept } = summary;
  return [
    made === asked ? `${made} variants` : `${made} of ${asked} variants could be made`,
    arrival ? `there after ${seconds(arrival)}` : `${seconds(duration)} long`,
    ...(path ? [`${centimetres(path.mean)} from the path on average, ${centimetres(path.max)} at most`] : []),
    ...(made > 1 ? [`joints ${centimetres(spread.clips)} apart on average`] : []),
    `together they pass over ${swept.area.toFixed(1)} m² of floor (outlined)`,
  ].join('; ') + '.';
}

export class VariantsPanel {
  private readonly show = byId<HTMLButtonElement>('show-variants');
  private readonly hide = byId<HTMLButtonElement>('hide-variants');
  private readonly count = byId<HTMLInputElement>('variant-count');
  private readonly summary = byId('variant-summary');
  private running?: AbortController;

  /** `read` gives the request that the page asks for now. */
  constructor(private readonly scene: ClipScene | undefined, read: () => ClipRequest | undefined, onError: (error: unknown) => void) {
    this.show.disabled = !scene;
    this.show.addEventListener('click', () => {
      const request = read();
      if (request) void this.ask(request).catch((error: ApiError | Error) => error.name !== 'AbortError' && onError(error));
    });
    this.hide.addEventListener('click', () => this.clear());
  }

  /** The variants of an older request go. */
  clear(): void {
    this.running?.abort();
    this.scene?.clearGhosts();
    this.summary.textContent = '';
    this.hide.hidden = true;
  }

  private async ask(request: ClipRequest): Promise<void> {
    this.clear();
    const own = (this.running = new AbortController());
    const count = Math.min(Math.max(Math.round(this.count.valueAsNumber) || 8, 1), 50);
    this.summary.textContent = 'Making variants…';
    try {
      const summary = await createVariants(request, count, (bvh) => !own.signal.aborted && this.scene?.addGhost(new ClipMotion(bvh)), own.signal);
      this.scene?.showSweptArea(summary.swept_area);
      this.summary.textContent = summaryText(summary);
      this.hide.hidden = false;
    } catch (error) {
      if (this.running === own) this.summary.textContent = '';
      throw error;
    }
  }
}
