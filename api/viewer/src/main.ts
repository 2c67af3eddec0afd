// Wires the page together: form -> server -> clip -> player -> stage, time line, curves and graph.
import { ApiError, createBvh, createClip, evaluate, fetchGraph, listModels, type ClipRequest, type ClipResponse } from './api_client';
import { ClipMotion } from './clip_motion';
import { ClipScene } from './clip_scene';
import { ControlPanel } from './control_panel';
import { Controls } from './controls';
import { Curves } from './curves';
import { byId, spoken } from './dom';
import { fileName, save } from './downloads';
import { FloorPen } from './floor_pen';
import { GraphView } from './graph_view';
import { Player } from './player';
import { hideProblem, showProblem } from './problem_banner';
import { showQuality } from './quality_panel';
import { RequestForm } from './request_form';
import { startShortcuts } from './shortcuts';
import { Stage, type View } from './stage';
import { startTheme } from './theme';
import { Timeline, currentStep } from './timeline';
import { VariantsPanel } from './variants_panel';

startTheme(byId('theme'));
const player = new Player();
const stage = openStage();
const scene = stage && new ClipScene(stage, player);
const timeline = new Timeline(byId('timeline'), player);
const curves = new Curves(byId('curves'), player);
const graph = new GraphView(byId('graph'), byId('graph-details'), byId<HTMLSelectElement>('graph-style'));
let clip: ClipResponse | undefined;
let motion: ClipMotion | undefined;
let lastRequest: ClipRequest | undefined;
let newest = 0; // number of the latest request; answers to older ones are dropped

const controls = new Controls();
const form = new RequestForm(controls, () => void synthesise(), (model) => void loadGraph(model));

// Drawing on the floor.
const pen = stage && new FloorPen(byId<HTMLCanvasElement>('stage'), stage, () => Math.round(player.time * 10) / 10,
  (drawn) => scene?.showControls(drawn ? [...controls.list, drawn] : controls.list),
  (drawn) => {
    panel.takePen(undefined);
    controls.add(drawn);
  });
const panel = new ControlPanel(controls, (kind) => {
  pen?.take(kind);
  if (!kind) return;
  player.toggle(false);
  look('map');
});
const variants = new VariantsPanel(scene, () => form.read(), (error) => {
  showProblem(error);
  if (error instanceof ApiError) markErrors(error);
});
controls.onChange(() => scene?.showControls(controls.list));
scene?.showControls(controls.list);

function markErrors(error: ApiError): void {
  form.markErrors(error);
  panel.showOutcomes([]);
  panel.markErrors(error);
}

function openStage(): Stage | undefined {
  try {
    return new Stage(byId<HTMLCanvasElement>('stage'));
  } catch {
    byId('no-webgl').hidden = false;
    return undefined;
  }
}

async function loadGraph(model: string): Promise<void> {
  try {
    graph.load(await fetchGraph(model));
    highlight(true);
  } catch (error) {
    showProblem(error);
  }
}

async function synthesise(): Promise<void> {
  const request = form.read();
  if (!request) return;
  const number = ++newest;
  variants.clear();
  byId('request').setAttribute('aria-busy', 'true');
  try {
    const answer = await createClip(request);
    if (number !== newest) return;
    show(answer, request);
    form.writeAddress();
    hideProblem();
    void addEvaluation(answer, number);
  } catch (error) {
    if (number !== newest) return;
    showProblem(error);
    if (error instanceof ApiError) markErrors(error);
  } finally {
    if (number === newest) byId('request').removeAttribute('aria-busy');
  }
}

async function addEvaluation(answer: ClipResponse, number: number): Promise<void> {
  try {
    const evaluation = await evaluate(answer.bvh);
    if (number === newest) curves.add(evaluation, answer.report.contacts);
  } catch (error) {
    // The clip itself is fine: no reason for an alarm.
    const reason = error instanceof ApiError ? `${error.title}: ${error.detail}` : String(error);
    if (number === newest) curves.addNote(`Frame difference and contact distance could not be measured. ${reason}`);
  }
}

function show(answer: ClipResponse, request: ClipRequest): void {
  const first = !clip;
  motion = new ClipMotion(answer.bvh);
  clip = answer;
  lastRequest = request;
  player.load(motion.frames, motion.frameTime);
  scene?.load(motion, answer.report);
  timeline.load(answer.report);
  curves.load(motion, answer.report.contacts);
  showQuality(byId('quality'), answer.report);
  panel.showOutcomes(answer.report.constraints);
  const { report } = answer;
  const style = report.style ? `, ${report.style}` : '';
  byId('status').textContent = `${report.duration.toFixed(1)} s${style}: ${report.frames} frames, ${report.steps.length} steps, ` +
    `made and sent in ${answer.milliseconds.toFixed(0)} ms`;
  for (const id of ['save-bvh', 'save-report']) byId<HTMLButtonElement>(id).disabled = false;
  highlight(true);
  scene?.look(view);
  // Playing starts by itself only once, and not for readers who asked for less motion.
  if (first && !matchMedia('(prefers-reduced-motion: reduce)').matches) player.toggle(true);
}

let litStep = -2;
function highlight(anew = false): void {
  const report = clip?.report;
  const step = currentStep(report, player.frame);
  if (!report || (step === litStep && !anew)) return;
  litStep = step;
  graph.highlight(report.steps[step - 1]?.primitive, report.steps[step]?.primitive, report.style ?? '');
  byId('current-step').textContent = step < 0 ? '' : spoken(report.steps[step].primitive);
}

player.onChange(() => {
  highlight();
  const button = byId('play');
  button.classList.toggle('playing', player.playing);
  button.setAttribute('aria-label', player.playing ? 'Pause' : 'Play');
  byId('clock').textContent = `${player.time.toFixed(2)} / ${player.duration.toFixed(2)} s`;
  byId('frame').textContent = `frame ${player.frame}`;
});
if (stage) stage.onFrame = (seconds) => player.advance(seconds);

// Controls of playback and camera.
const speed = byId<HTMLSelectElement>('speed');
const follow = byId<HTMLInputElement>('follow');
let view: View = 'corner';
function look(next: View): void {
  view = next;
  for (const button of document.querySelectorAll<HTMLElement>('[data-view]')) {
    button.setAttribute('aria-pressed', String(button.dataset.view === next));
  }
  scene?.look(next);
}
function changeSpeed(by: number): void {
  speed.selectedIndex = Math.min(Math.max(speed.selectedIndex + by, 0), speed.options.length - 1);
  player.setSpeed(Number(speed.value));
}
byId('play').addEventListener('click', () => player.toggle());
speed.addEventListener('change', () => player.setSpeed(Number(speed.value)));
follow.addEventListener('change', () => {
  if (stage) stage.follow = follow.checked;
  if (follow.checked) scene?.look(view);
});
for (const button of document.querySelectorAll<HTMLElement>('[data-view]')) {
  button.addEventListener('click', () => look(button.dataset.view as View));
}
startShortcuts({
  ' ': () => player.toggle(),
  ArrowLeft: (shift) => player.stepFrames(shift ? -10 : -1),
  ArrowRight: (shift) => player.stepFrames(shift ? 10 : 1),
  Home: () => player.seek(0),
  End: () => player.seek(player.duration),
  '[': () => changeSpeed(-1),
  ']': () => changeSpeed(1),
  n: () => form.nextSeed(),
  f: () => follow.click(),
  '1': () => look('corner'),
  '2': () => look('side'),
  '3': () => look('front'),
  '4': () => look('top'),
});

byId('save-bvh').addEventListener('click', async () => {
  if (!clip || !lastRequest) return;
  const unit = byId<HTMLSelectElement>('save-unit').value as ClipRequest['output']['unit'];
  try {
    const bvh = await createBvh({ ...lastRequest, output: { ...lastRequest.output, unit } });
    save(bvh, fileName(lastRequest.model, clip.report.style, clip.seed, '.bvh'), 'text/plain');
  } catch (error) {
    showProblem(error);
  }
});
byId('save-report').addEventListener('click', () => {
  if (!clip || !lastRequest) return;
  save(clip.reportText, fileName(lastRequest.model, clip.report.style, clip.seed, '.report.json'), 'application/json');
});

async function start(): Promise<void> {
  const models = await listModels();
  if (models.length > 0) return form.offer(models);
  throw new Error('This server holds no model, so there is nothing to play. Start it with --model FILE, or send recordings to POST /v1/models.');
}
start().catch((error) => {
  byId('status').textContent = 'Nothing to play';
  showProblem(error);
});

// A handle for the console and for tests: what is being shown, without reaching into modules.
Object.assign(window, {
  morphograph: {
    get state() {
      return { frame: player.frame, frames: player.frames, time: player.time, playing: player.playing, seed: clip?.seed, report: clip?.report, controls: controls.list, ghosts: scene?.ghostCount };
    },
    /** World positions of all joints as they are posed now, metres. */
    joints: () => motion?.bones.map((bone) => {
      bone.updateWorldMatrix(true, false);
      return [bone.matrixWorld.elements[12], bone.matrixWorld.elements[13], bone.matrixWorld.elements[14]];
    }) ?? [],
    /** The point of the window where a place [x, z] on the floor is seen. */
    windowAt: (place: [number, number]) => stage?.windowAt(place),
    /** Draws at once, so that the canvas can be read back in the same task. */
    render: () => stage?.render(),
  },
});
