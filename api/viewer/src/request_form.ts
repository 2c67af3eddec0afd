// The form that says what to synthesise. Its state also stands in the page's address, so that a clip can be linked to.
import type { ApiError, Boundary, ClipRequest, ModelEntry } from './api_client';
import type { Controls } from './controls';
import { byId, html, spoken } from './dom';

const SEED_LIMIT = 2n ** 64n;
const WALKING = 'walking';
const AUTO = 'auto'; // as long as the way takes

/** Whether a boundary other than the usual one was chosen. */
const asked = (select: HTMLSelectElement): boolean => select.value !== '' && select.value !== WALKING;

function choose(select: HTMLSelectElement, value: string | null): void {
  if (value && [...select.options].some((option) => option.value === value)) select.value = value;
}

export class RequestForm {
  private readonly form = byId<HTMLFormElement>('request');
  private readonly model = byId<HTMLSelectElement>('model');
  private readonly style = byId<HTMLSelectElement>('style');
  private readonly seed = byId<HTMLInputElement>('seed');
  private readonly length = byId<HTMLInputElement>('length');
  private readonly lengthUnit = byId<HTMLSelectElement>('length-unit');
  private readonly boundaries = byId('boundaries');
  private readonly startFrom = byId<HTMLSelectElement>('start-from');
  private readonly end = byId<HTMLSelectElement>('end');
  private readonly heading = byId<HTMLInputElement>('heading');
  private readonly rate = byId<HTMLInputElement>('rate');
  private readonly pace = byId<HTMLInputElement>('pace');
  private models: ModelEntry[] = [];
  private hadWay = false;

  /** `onRequest` is called whenever the request changed or is asked for again; `onModel` when another model is chosen. */
  constructor(private readonly controls: Controls, private readonly onRequest: () => void, private readonly onModel: (name: string) => void) {
    this.form.addEventListener('submit', (event) => {
      event.preventDefault();
      this.ask();
    });
    this.form.addEventListener('change', (event) => {
      if (event.target === this.model) {
        this.offerStyles();
        this.onModel(this.model.value);
      }
      if (event.target === this.style) this.offerBoundaries();
      if (event.target === this.lengthUnit) this.offerLength();
      this.ask();
    });
    byId('next-seed').addEventListener('click', () => this.nextSeed());
    byId('random-seed').addEventListener('click', () => {
      const words = crypto.getRandomValues(new BigUint64Array(1));
      this.seed.value = String(words[0] >> 32n); // ten digits are enough to type again
      this.ask();
    });
    this.readAddress();
    this.offerLength(this.length.value);
    controls.onChange(() => {
      const was = this.lengthUnit.value;
      // A way takes the time that it takes, unless something else was chosen; without one there is nothing to take.
      if (controls.hasWay && !this.hadWay) this.lengthUnit.value = AUTO;
      if (!controls.hasWay && was === AUTO) this.lengthUnit.value = 'duration';
      this.hadWay = controls.hasWay;
      if (this.lengthUnit.value !== was) this.offerLength();
      this.ask();
    });
  }

  offer(models: ModelEntry[]): void {
    this.models = models;
    const wanted = new URLSearchParams(location.search);
    this.model.replaceChildren(...models.map(({ name }) => html('option', { value: name }, name)));
    if (models.some(({ name }) => name === wanted.get('model'))) this.model.value = wanted.get('model')!;
    this.offerStyles();
    const style = wanted.get('style');
    if (style && [...this.style.options].some(({ value }) => value === style)) this.style.value = style;
    this.offerBoundaries();
    choose(this.startFrom, wanted.get('from'));
    choose(this.end, wanted.get('end'));
    this.onModel(this.model.value);
    this.onRequest();
  }

  nextSeed(): void {
    if (!/^\d+$/.test(this.seed.value.trim())) return this.ask();
    this.seed.value = String((BigInt(this.seed.value) + 1n) % SEED_LIMIT);
    this.ask();
  }

  /** The request that the fields say, or undefined (with the field marked) where they say nothing that could be sent. */
  read(): ClipRequest | undefined {
    this.clearMarks();
    const seed = this.seed.value.trim();
    // Any whole number is sent, so that the server is the one judge of its size.
    if (!/^-?\d+$/.test(seed)) return this.mark(this.seed, 'The seed is a whole number.');
    const unit = this.lengthUnit.value;
    const length = this.length.valueAsNumber;
    if (unit !== AUTO && !Number.isFinite(length)) return this.mark(this.length, 'Give a number.');
    const request: ClipRequest = { model: this.model.value, seed: BigInt(seed).toString(), output: { unit: 'm' } };
    if (this.style.value) request.style = this.style.value;
    if (unit !== AUTO) request[unit === 'steps' ? 'steps' : 'duration'] = length;
    if (this.heading.value) request.start = { heading: this.heading.valueAsNumber };
    if (asked(this.startFrom)) request.start = { ...request.start, from: this.startFrom.value };
    if (asked(this.end)) request.end = this.end.value;
    if (this.pace.value) request.speed = this.pace.valueAsNumber;
    if (this.rate.value) request.output.frame_rate = this.rate.valueAsNumber;
    return { ...request, ...this.controls.fields() };
  }

  /** Marks the fields that the server found fault with. */
  markErrors(error: ApiError): void {
    const fields: Record<string, HTMLElement> = {
      '/model': this.model, '/style': this.style, '/seed': this.seed, '/duration': this.length, '/steps': this.length,
      '/start/heading': this.heading, '/start/from': this.startFrom, '/end': this.end, '/output/frame_rate': this.rate,
      '/speed': this.pace,
    };
    for (const { pointer, detail } of error.errors) {
      const field = fields[pointer];
      if (field) this.mark(field, detail);
    }
  }

  writeAddress(): void {
    const query = new URLSearchParams();
    query.set('model', this.model.value);
    query.set('seed', this.seed.value);
    if (this.style.value) query.set('style', this.style.value);
    if (this.lengthUnit.value !== AUTO) query.set(this.lengthUnit.value, this.length.value);
    if (asked(this.startFrom)) query.set('from', this.startFrom.value);
    if (asked(this.end)) query.set('end', this.end.value);
    if (this.heading.value) query.set('heading', this.heading.value);
    if (this.rate.value) query.set('rate', this.rate.value);
    if (this.pace.value) query.set('pace', this.pace.value);
    if (this.controls.list.length > 0) query.set('controls', this.controls.toText());
    history.replaceState(null, '', `?${query}`);
  }

  private offerLength(value = this.lengthUnit.value === 'steps' ? '12' : '8'): void {
    const auto = this.lengthUnit.value === AUTO;
    this.length.disabled = auto;
    this.length.value = auto ? '' : value;
  }

  private ask(): void {
    if (this.models.length > 0) this.onRequest();
  }

  private offerStyles(): void {
    const before = this.style.value;
    const styles = this.models.find(({ name }) => name === this.model.value)?.styles ?? [];
    this.style.replaceChildren(html('option', { value: '' }, styles.length > 0 ? 'any (drawn by the seed)' : 'the only one'),
      ...styles.filter((style) => style !== '').map((style) => html('option', { value: style }, style)));
    this.style.disabled = styles.length === 0;
    if (styles.includes(before)) this.style.value = before;
    this.offerBoundaries();
  }

  /** Offers what the chosen style (any style, where none is chosen) has learned; nothing to choose, nothing shown. */
  private offerBoundaries(): void {
    const all = this.models.find(({ name }) => name === this.model.value)?.boundaries ?? [];
    const own = all.filter(({ style }) => !this.style.value || style === this.style.value);
    const offer = (select: HTMLSelectElement, known: Boundary[]) => {
      const before = select.value;
      const offered = [...new Set([WALKING, ...known])];
      select.replaceChildren(...offered.map((boundary) => html('option', { value: boundary }, spoken(boundary))));
      select.disabled = offered.length < 2;
      choose(select, before);
    };
    offer(this.startFrom, own.flatMap(({ start_from }) => start_from));
    offer(this.end, own.flatMap(({ end }) => end));
    this.boundaries.hidden = this.startFrom.disabled && this.end.disabled;
  }

  private readAddress(): void {
    const query = new URLSearchParams(location.search);
    if (query.has('seed')) this.seed.value = query.get('seed')!;
    for (const unit of ['duration', 'steps']) {
      if (query.has(unit)) [this.lengthUnit.value, this.length.value] = [unit, query.get(unit)!];
    }
    this.heading.value = query.get('heading') ?? '';
    this.rate.value = query.get('rate') ?? '';
    this.pace.value = query.get('pace') ?? '';
    this.controls.readText(query.get('controls') ?? '[]');
    this.hadWay = this.controls.hasWay;
    if (this.hadWay && !query.has('duration') && !query.has('steps')) this.lengthUnit.value = AUTO;
  }

  private mark(field: HTMLElement, detail: string): undefined {
    field.setAttribute('aria-invalid', 'true');
    const hint = html('p', { class: 'field-error', id: `${field.id}-error` }, detail);
    field.setAttribute('aria-describedby', hint.id);
    field.closest('.field')?.append(hint);
    return undefined;
  }

  private clearMarks(): void {
    for (const hint of this.form.querySelectorAll('.field-error')) hint.remove();
    for (const field of this.form.querySelectorAll('[aria-invalid]')) {
      field.removeAttribute('aria-invalid');
      field.removeAttribute('aria-describedby');
    }
  }
}
