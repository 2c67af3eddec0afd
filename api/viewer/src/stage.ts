// The room: ground, light, camera. Draws only when something changed, and lowers its own demands where drawing is slow
// (software WebGL, old phones).
import {
  AmbientLight, Color, DirectionalLight, Fog, HemisphereLight, Mesh, Object3D, PCFShadowMap, PerspectiveCamera,
  Plane, PlaneGeometry, Raycaster, Scene, ShadowMaterial, Vector2, Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { FloorGrid } from './floor_grid';
import { onTheme, themeColour } from './theme';

export type View = 'corner' | 'side' | 'front' | 'top' | 'map';

const GROUND_M = 60;
const SIGHT_M = 40;
const LOOK_HEIGHT_M = 0.88;
const SLOW_FRAME_MS = 45;

export class Stage {
  follow = true;
  onFrame: (seconds: number) => void = () => {};
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(38, 1, 0.05, 200);
  private readonly controls: OrbitControls;
  private readonly sun = new DirectionalLight(0xffffff, 2.1);
  private readonly ground: Mesh<PlaneGeometry, ShadowMaterial>;
  private readonly grid = new FloorGrid();
  private readonly focus = new Vector3(0, LOOK_HEIGHT_M, 0);
  private dirty = true;
  private last = 0;
  private costs: number[] = [];
  private readonly savings: (() => void)[] = [
    () => this.renderer.setPixelRatio(1),
    () => (this.sun.castShadow = false),
    () => this.renderer.setPixelRatio(0.7),
  ];

  /** @throws Error when the browser offers no WebGL. */
  constructor(canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.maxPolarAngle = Math.PI / 2 - 0.03;
    this.controls.minDistance = 1;
    this.controls.maxDistance = 30;
    this.controls.addEventListener('change', () => (this.dirty = true));
    this.ground = new Mesh(new PlaneGeometry(GROUND_M, GROUND_M).rotateX(-Math.PI / 2), new ShadowMaterial({ opacity: 0.28 }));
    this.ground.receiveShadow = true;
    this.ground.renderOrder = -1;
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(1024, 1024);
    this.sun.shadow.radius = 3;
    this.sun.shadow.normalBias = 0.02;
    Object.assign(this.sun.shadow.camera, { left: -1.6, right: 1.6, top: 2.2, bottom: -1.6, near: 0.5, far: 12 });
    this.scene.add(this.grid.object, this.ground, this.sun, this.sun.target, new HemisphereLight(0xffffff, 0x8f8a80, 1.5), new AmbientLight(0xffffff, 0.35));
    this.recolour();
    onTheme(() => this.recolour());
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement!);
    this.resize();
    requestAnimationFrame((now) => this.loop(now));
  }

  add(object: Object3D): void {
    this.scene.add(object);
    this.dirty = true;
  }

  remove(object: Object3D): void {
    this.scene.remove(object);
    this.dirty = true;
  }

  invalidate(): void {
    this.dirty = true;
  }

  /** Whether the pointer turns the camera. */
  set orbits(on: boolean) {
    this.controls.enabled = on;
  }

  /** The place [x, z] on the floor that is seen at a point of the window; undefined where that shows the far distance or the sky. */
  floorAt(clientX: number, clientY: number): [number, number] | undefined {
    const box = this.renderer.domElement.getBoundingClientRect();
    const seen = new Vector2(((clientX - box.left) / box.width) * 2 - 1, 1 - ((clientY - box.top) / box.height) * 2);
    this.camera.updateMatrixWorld();
    const ray = new Raycaster();
    ray.setFromCamera(seen, this.camera);
    const place = ray.ray.intersectPlane(new Plane(new Vector3(0, 1, 0)), new Vector3());
    return place && place.distanceTo(this.camera.position) < SIGHT_M ? [place.x, place.z] : undefined;
  }

  /** The point of the window where a place on the floor is seen. */
  windowAt([x, z]: [number, number]): [number, number] {
    this.camera.updateMatrixWorld();
    const box = this.renderer.domElement.getBoundingClientRect();
    const seen = new Vector3(x, 0, z).project(this.camera);
    return [box.left + ((seen.x + 1) / 2) * box.width, box.top + ((1 - seen.y) / 2) * box.height];
  }

  /** Tells where the figure is; the camera goes along when it follows. */
  moveFocus(x: number, z: number): void {
    const dx = x - this.focus.x;
    const dz = z - this.focus.z;
    this.focus.set(x, LOOK_HEIGHT_M, z);
    if (this.follow) {
      this.controls.target.add(new Vector3(dx, 0, dz));
      this.camera.position.add(new Vector3(dx, 0, dz));
    }
    this.sun.target.position.set(x, 0.6, z);
    this.sun.position.set(x + 2.2, 5.2, z + 1.6);
    this.ground.position.set(x, 0.001, z); // goes with the figure, so that it never ends
    this.grid.centre(x, z);
    this.dirty = true;
  }

  /** Places the camera, seen from the direction that the figure faces. */
  look(view: View, facing: Vector3): void {
    const across = new Vector3(0, 1, 0).cross(facing);
    const place: Record<View, [ahead: number, aside: number, up: number]> = {
      corner: [3.1, 2.5, 1.1],
      side: [0, 4.0, 0.12],
      front: [4.0, 0, 0.12],
      top: [-0.02, 0, 5.5],
      map: [-0.02, 0, 8.5],
    };
    const [ahead, aside, up] = place[view];
    // A tall window (a phone held upright) must stand further back to show the figure and its next steps.
    const back = Math.max(1, 1.15 / Math.max(this.camera.aspect, 0.5));
    this.controls.target.copy(this.focus);
    this.camera.position.copy(this.focus)
      .addScaledVector(facing, ahead * back).addScaledVector(across, aside * back).add(new Vector3(0, up * back, 0));
    this.controls.update();
    this.dirty = true;
  }

  /** Draws at once, for whoever must read the picture back. */
  render(): void {
    this.controls.update();
    this.renderer.render(this.scene, this.camera);
  }

  private loop(now: number): void {
    requestAnimationFrame((next) => this.loop(next));
    const seconds = Math.min((now - this.last) / 1000, 0.25); // a hidden tab must not leap
    this.last = now;
    this.onFrame(seconds);
    if (!this.dirty) return;
    this.dirty = false;
    const started = performance.now();
    this.render();
    this.watchCost(Math.max(performance.now() - started, seconds * 1000));
  }

  /** Gives up sharpness, then shadows, when the last frames took long. */
  private watchCost(milliseconds: number): void {
    this.costs.push(milliseconds);
    if (this.costs.length < 24) return;
    const median = this.costs.sort((a, b) => a - b)[12];
    this.costs = [];
    if (median > SLOW_FRAME_MS && this.savings.length > 0) {
      this.savings.shift()!();
      this.resize();
    }
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.renderer.domElement.parentElement!;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.dirty = true;
  }

  private recolour(): void {
    const sky = new Color(themeColour('--stage'));
    this.scene.background = sky;
    this.scene.fog = new Fog(sky, 9, 24);
    this.grid.recolour();
    this.dirty = true;
  }
}
