// The motion graph: a box for each primitive, an arrow for each transition with its probability. The step being played is lit.
import { graphlib, layout } from '@dagrejs/dagre';
import type { Edge, Graph, Primitive } from './api_client';
import { html, spoken, svg } from './dom';

interface Drawn { primitive: Primitive; element: SVGGElement }

export class GraphView {
  private graph: Graph = { primitives: [], edges: [] };
  private nodes = new Map<number, Drawn>();
  private arrows = new Map<string, SVGGElement>();
  private shown: string | null = null; // style; null = all of them
  private lit: SVGGElement[] = [];

  constructor(
    private readonly host: HTMLElement,
    private readonly details: HTMLElement,
    private readonly styleChoice: HTMLSelectElement,
  ) {
    styleChoice.addEventListener('change', () => this.show(styleChoice.value === '*' ? null : styleChoice.value));
  }

  load(graph: Graph): void {
    this.graph = graph;
    const styles = [...new Set(graph.primitives.map((primitive) => primitive.style ?? ''))];
    this.styleChoice.replaceChildren(
      ...styles.map((style) => html('option', { value: style }, style || 'no style')),
      ...(styles.length > 1 ? [html('option', { value: '*' }, 'all styles')] : []));
    this.styleChoice.parentElement!.hidden = styles.length < 2;
    this.show(styles.length > 1 ? styles[0] : null);
  }

  /** Lights a step and the transition that led to it; a step of another style brings its part of the graph into view. */
  highlight(previous: string | undefined, current: string | undefined, style: string): void {
    for (const element of this.lit) element.classList.remove('current');
    this.lit = [];
    const to = this.find(current, style);
    if (to < 0) return;
    const own = this.graph.primitives[to].style ?? '';
    if (this.shown !== null && this.shown !== own) this.show(own);
    const from = this.find(previous, style);
    this.lit = [this.nodes.get(to)?.element, this.arrows.get(`${from}-${to}`)].filter((e) => e !== undefined);
    for (const element of this.lit) element.classList.add('current');
  }

  private find(name: string | undefined, style: string): number {
    if (!name) return -1;
    const { primitives } = this.graph;
    const exact = primitives.findIndex((p) => p.name === name && (p.style ?? '') === style);
    return exact >= 0 ? exact : primitives.findIndex((p) => p.name === name);
  }

  private show(style: string | null): void {
    this.shown = style;
    this.styleChoice.value = style ?? '*';
    const kept = this.graph.primitives.map((_, i) => i).filter((i) => style === null || (this.graph.primitives[i].style ?? '') === style);
    const edges = this.graph.edges.filter(({ from, to }) => kept.includes(from) && kept.includes(to));
    this.draw(kept, edges);
    this.details.textContent = 'Choose a primitive to see what it was learned from.';
  }

  private draw(kept: number[], edges: Edge[]): void {
    const placed = new graphlib.Graph();
    placed.setGraph({ rankdir: 'TB', nodesep: 34, ranksep: 46, edgesep: 26, marginx: 14, marginy: 12 });
    placed.setDefaultEdgeLabel(() => ({}));
    for (const i of kept) {
      const label = spoken(this.graph.primitives[i].name);
      placed.setNode(String(i), { label, width: Math.max(96, label.length * 7.2 + 22), height: 42 });
    }
    for (const { from, to } of edges) placed.setEdge(String(from), String(to), { width: 34, height: 16, labelpos: 'c' });
    layout(placed);

    const { width = 100, height = 60 } = placed.graph();
    const picture = svg('svg', { viewBox: `0 0 ${width} ${height}`, class: 'graph-drawing', width, height, role: 'group',
      'aria-label': `Motion graph: ${kept.length} primitives, ${edges.length} transitions` },
    svg('defs', {}, marker('arrow'), marker('arrow-current')));
    this.nodes.clear();
    this.arrows.clear();
    this.lit = [];
    for (const edge of edges) {
      const { points, x, y } = placed.edge(String(edge.from), String(edge.to)) as { points: Point[]; x: number; y: number };
      const text = percent(edge.probability);
      const arrow = svg('g', { class: 'edge' },
        svg('title', {}, edgeTitle(this.graph, edge)),
        svg('path', { d: curve(points), 'stroke-width': (0.9 + 2.6 * edge.probability).toFixed(2) }),
        svg('rect', { x: x - text.length * 3.4 - 4, y: y - 8, width: text.length * 6.8 + 8, height: 16, rx: 8 }),
        svg('text', { x, y: y + 4, 'text-anchor': 'middle' }, text));
      this.arrows.set(`${edge.from}-${edge.to}`, arrow);
      picture.append(arrow);
    }
    for (const i of kept) {
      const primitive = this.graph.primitives[i];
      const { x, y, width: w, height: h } = placed.node(String(i)) as { x: number; y: number; width: number; height: number };
      const count = primitive.examples === undefined ? '' : `${primitive.examples} examples`;
      const element = svg('g', { class: primitive.dead_end ? 'node dead-end' : 'node', tabindex: 0, role: 'button', 'aria-label': `${spoken(primitive.name)}, ${count}` },
        svg('rect', { x: x - w / 2, y: y - h / 2, width: w, height: h, rx: 10 }),
        svg('text', { x, y: count ? y - 3 : y + 4, 'text-anchor': 'middle', class: 'node-name' }, spoken(primitive.name)),
        svg('text', { x, y: y + 13, 'text-anchor': 'middle', class: 'node-count' }, count));
      const choose = () => this.describe(i);
      element.addEventListener('click', choose);
      element.addEventListener('keydown', (event) => {
        if (event.key !== 'Enter' && event.key !== ' ') return;
        event.preventDefault();
        event.stopPropagation(); // the space bar plays and pauses elsewhere
        choose();
      });
      this.nodes.set(i, { primitive, element });
      picture.append(element);
    }
    this.host.replaceChildren(picture);
  }

  private describe(index: number): void {
    for (const [i, { element }] of this.nodes) element.classList.toggle('chosen', i === index);
    const primitive = this.graph.primitives[index];
    const rows: [string, string | undefined][] = [
      ['from', primitive.start && `${spoken(primitive.start)} to ${spoken(primitive.end ?? '')}`],
      ['style', primitive.style || undefined],
      ['examples', primitive.examples === undefined ? undefined
        : `${primitive.examples}` + (primitive.made_examples ? `, ${primitive.made_examples} of them mirrored or made` : '')],
      ['components', primitive.components === undefined ? undefined
        : `${primitive.components}` + (primitive.variance_kept ? `, ${(primitive.variance_kept * 100).toFixed(1)} % of variance` : '')],
      ['mixture', primitive.mixture_size === undefined ? undefined : `${primitive.mixture_size} component${primitive.mixture_size === 1 ? '' : 's'}`],
      ['mean duration', primitive.mean_duration === undefined ? undefined : `${primitive.mean_duration.toFixed(2)} s`],
      ['ends', primitive.dead_end ? 'no transition leaves it' : undefined],
    ];
    const list = html('dl', { class: 'facts' });
    for (const [name, value] of rows) if (value) list.append(html('dt', {}, name), html('dd', {}, value));
    this.details.replaceChildren(html('strong', {}, spoken(primitive.name)), list);
  }
}

interface Point { x: number; y: number }

/** A smooth line through all points of a route (Catmull-Rom as cubic pieces), so that it meets its label. */
function curve(points: Point[]): string {
  const at = (x: number, y: number) => `${x.toFixed(1)} ${y.toFixed(1)}`;
  let d = `M${at(points[0].x, points[0].y)}`;
  for (let i = 0; i + 1 < points.length; ++i) {
    const [before, from, to, after] = [points[Math.max(i - 1, 0)], points[i], points[i + 1], points[Math.min(i + 2, points.length - 1)]];
    d += `C${at(from.x + (to.x - before.x) / 6, from.y + (to.y - before.y) / 6)} ` +
      `${at(to.x - (after.x - from.x) / 6, to.y - (after.y - from.y) / 6)} ${at(to.x, to.y)}`;
  }
  return d;
}

function marker(id: string): SVGMarkerElement {
  return svg('marker', { id, viewBox: '0 0 8 8', refX: 7, refY: 4, markerWidth: 8, markerHeight: 8, markerUnits: 'userSpaceOnUse', orient: 'auto' },
    svg('path', { d: 'M0 0.6L8 4L0 7.4Z' }));
}

function percent(probability: number): string {
  const value = probability * 100;
  return value > 0 && value < 1 ? '<1 %' : `${Math.round(value)} %`;
}

function edgeTitle(graph: Graph, { from, to, probability, pairs }: Edge): string {
  const names = `${spoken(graph.primitives[from].name)} to ${spoken(graph.primitives[to].name)}`;
  return `${names}: ${percent(probability)}${pairs === undefined ? '' : `, ${pairs} pairs`}`;
}
