// Talks to the HTTP interface, version 1. Seeds are 64-bit, which JSON numbers of a browser cannot hold: they stay decimal text.

export interface Step { primitive: string; from: number; to: number; log_likelihood?: number }
export interface Contact { foot: 'left' | 'right'; from: number; to: number; position: [number, number] }

export interface Quality {
  contact_distance: number;
  foot_skate_cm_s: number;
  penetration: number;
  naturalness: number;
  log_likelihood?: number | null;
}

/** What became of something that was asked for; `pointer` leads into the request. */
export interface ConstraintOutcome { index?: number; pointer: string; met: boolean; residual: number; unit: string }

export interface Report {
  model: { name: string; hash: string };
  style?: string;
  duration: number;
  frames: number;
  steps: Step[];
  contacts: Contact[];
  path: [number, number][];
  constraints: ConstraintOutcome[];
  quality: Quality;
}

/** What a clip begins out of, or ends in: "walking", "slow_step" or "standing". */
export type Boundary = string;
export interface StyleBoundaries { style: string; start_from: Boundary[]; end: Boundary[] }

export interface ModelEntry {
  name: string;
  action?: string;
  hash?: string;
  styles: string[];
  boundaries?: StyleBoundaries[];
  attribution?: string;
  licence?: string;
}

export interface Primitive {
  name: string;
  style?: string;
  start?: string;
  end?: string;
  examples?: number;
  made_examples?: number;
  components?: number;
  variance_kept?: number;
  mixture_size?: number;
  mean_duration?: number;
  dead_end?: boolean;
}

export interface Edge { from: number; to: number; probability: number; pairs?: number }
export interface Graph { primitives: Primitive[]; edges: Edge[] }

export interface ClipRequest {
  model: string;
  seed: string;
  style?: string;
  duration?: number;
  steps?: number;
  start?: { heading?: number; from?: Boundary };
  end?: Boundary;
  path?: { points: [number, number][]; interpolation?: 'linear' | 'spline' };
  goal?: { position: [number, number]; heading?: number };
  speed?: number;
  constraints?: object[];
  output: { unit: 'm' | 'cm' | 'source'; frame_rate?: number };
}

export interface Range { min: number; mean: number; max: number }
type Ring = [number, number][];

/** What the variants of a request have in common and how far they lie apart: metres, seconds, square metres. */
export interface VariantSummary {
  asked: number;
  made: number;
  unmet: number;
  duration: Range;
  arrival_time?: Range;
  path_deviation?: { mean: number; max: number };
  spread: { clips: number; steps: number };
  swept_area: { area: number; margin: number; resolution: number; polygons: { outline: Ring; holes: Ring[] }[] };
}

export interface ClipResponse { bvh: string; report: Report; reportText: string; seed: string; location: string; milliseconds: number }

/** What went wrong, as RFC 9457 problem+json tells it. */
export class ApiError extends Error {
  constructor(
    readonly title: string,
    readonly status: number,
    readonly detail: string,
    readonly errors: { pointer: string; detail: string }[] = [],
  ) {
    super(`${title}: ${detail}`);
  }
}

async function send(path: string, init: RequestInit): Promise<Response> {
  let response: Response;
  try {
    response = await fetch(path, init);
  } catch {
    throw new ApiError('The server does not answer', 0, 'No connection to it could be made. Is it still running?');
  }
  if (response.ok) return response;
  const type = response.headers.get('Content-Type') ?? '';
  if (/json/.test(type)) {
    const problem = await response.json().catch(() => ({}));
    throw new ApiError(problem.title ?? response.statusText, response.status, problem.detail ?? '', problem.errors ?? []);
  }
  throw new ApiError(response.statusText || 'Request failed', response.status, `The server answered with status ${response.status}.`);
}

/** The request as JSON text, with the seed as a plain number of any size. */
export function requestText(request: ClipRequest): string {
  const { seed, ...rest } = request;
  const text = JSON.stringify(rest);
  return `${text.slice(0, -1)},"seed":${seed}}`;
}

export async function listModels(): Promise<ModelEntry[]> {
  const body = await (await send('v1/models', { headers: { Accept: 'application/json' } })).json();
  return (Array.isArray(body) ? body : body.models) as ModelEntry[];
}

export async function fetchGraph(model: string): Promise<Graph> {
  const path = `v1/models/${encodeURIComponent(model)}/graph`;
  return (await send(path, { headers: { Accept: 'application/json' } })).json();
}

function post(request: ClipRequest, accept: string, signal?: AbortSignal): Promise<Response> {
  return send('v1/clips', {
    method: 'POST',
    headers: { 'Content-Type': 'application/json', Accept: accept },
    body: requestText(request),
    signal,
  });
}

export async function createClip(request: ClipRequest): Promise<ClipResponse> {
  const started = performance.now();
  const response = await post(request, 'application/json');
  const text = await response.text();
  const milliseconds = performance.now() - started;
  const body = JSON.parse(text) as { bvh: string; report: Report };
  return {
    ...body,
    reportText: reportFromBody(text),
    seed: response.headers.get('Morphograph-Seed') ?? request.seed,
    location: response.headers.get('Location') ?? '',
    milliseconds,
  };
}

/** Asks for many clips of one request; `onClip` gets each as it arrives, the likeliest first. */
export async function createVariants(request: ClipRequest, count: number, onClip: (bvh: string) => void, signal?: AbortSignal): Promise<VariantSummary> {
  const text = requestText(request);
  const response = await send('v1/variants', {
    method: 'POST',
    headers: { 'Content-Type': 'application/json', Accept: 'application/x-ndjson' },
    body: `${text.slice(0, -1)},"count":${count}}`,
    signal,
  });
  let summary: VariantSummary | undefined;
  const take = (line: string) => {
    const value = JSON.parse(line) as { bvh?: string; summary?: VariantSummary };
    if (value.bvh) onClip(value.bvh);
    summary ??= value.summary;
  };
  let rest = '';
  const reader = response.body!.pipeThrough(new TextDecoderStream()).getReader();
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    const lines = (rest + part.value).split('\n');
    rest = lines.pop()!;
    lines.forEach(take);
  }
  if (!summary) throw new ApiError('The answer broke off', 0, 'The server sent only a part of the variants.');
  return summary;
}

export async function createBvh(request: ClipRequest): Promise<string> {
  return (await post(request, 'text/plain')).text();
}

/** Curves of `POST /v1/evaluations`: metres, and square metres from a frame to the next; null where there is no number. */
export interface EvaluationCurves { contact_distance: (number | null)[]; frame_difference: (number | null)[] }

export async function evaluate(bvh: string): Promise<EvaluationCurves> {
  const headers = { 'Content-Type': 'text/plain; charset=utf-8', Accept: 'application/json' };
  return (await (await send('v1/evaluations', { method: 'POST', headers, body: bvh })).json()).curves;
}

/** The report as the server wrote it, seed to its last digit; `"report"` is a member of the outermost object. */
function reportFromBody(text: string): string {
  const at = text.lastIndexOf('"report":');
  const body = JSON.parse(text).report;
  const raw = text.slice(at + 9, text.lastIndexOf('}')).trim();
  // A member may follow the report; then it is written anew, at the cost of the seed's last digits.
  try {
    JSON.parse(raw);
    return raw;
  } catch {
    return JSON.stringify(body, null, 2);
  }
}
