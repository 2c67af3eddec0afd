// The body: meshes fixed to the bones of a clip, so that posing the bones moves the figure. Trunk and feet are hulls shaped on a
// frame of the clip itself, because a BVH's own zero pose may be anything.
import { Bone, BufferGeometry, Group, Mesh, MeshStandardMaterial, Quaternion, SphereGeometry, Vector3 } from 'three';
import type { Contact } from './api_client';
import type { ClipMotion } from './clip_motion';
import type { Role } from './joint_roles';
import { hull, taperedCapsule, type Ball } from './shapes';
import { themeColour } from './theme';

type Side = 'left' | 'right';
const LEG_M = 0.84; // hip to ankle of the body that the radii below are meant for

// Radii at the upper and the lower end of each limb, metres.
const LIMBS: [part: string, lower: string, from: number, to: number][] = [
  ['hip', 'knee', 0.078, 0.052],
  ['knee', 'ankle', 0.052, 0.036],
  ['shoulder', 'elbow', 0.046, 0.035],
  ['elbow', 'wrist', 0.035, 0.025],
];

export class Figure {
  readonly object = new Group();
  private readonly body = new MeshStandardMaterial({ roughness: 0.62, metalness: 0.02 });
  private readonly joint = new MeshStandardMaterial({ roughness: 0.5, metalness: 0.05 });
  private readonly limb = { left: this.body.clone(), right: this.body.clone() };
  private readonly shoe = { left: this.body.clone(), right: this.body.clone() };
  private readonly size: number;
  private readonly drawn = new Set<Bone>(); // bones whose link to their parent some mesh shows already

  constructor(private readonly motion: ClipMotion, contacts: Contact[]) {
    this.size = this.legLength() / LEG_M;
    this.object.add(motion.root);
    this.object.updateMatrixWorld(true);
    const reference = Math.floor(motion.frames / 2);
    this.poseAt(reference);
    this.buildTrunk(reference);
    for (const side of ['left', 'right'] as const) {
      for (const [part, lower, from, to] of LIMBS) this.buildLimb(side, part, lower, from, to);
      this.buildHand(side);
    }
    for (const side of ['left', 'right'] as const) this.buildFoot(side, contacts);
    this.buildRest();
    this.object.traverse((object) => (object.castShadow = object instanceof Mesh));
    this.recolour();
  }

  /** Takes the theme's colours anew. */
  recolour(): void {
    this.body.color.set(themeColour('--figure-body'));
    this.joint.color.set(themeColour('--figure-joint'));
    for (const side of ['left', 'right'] as const) {
      this.limb[side].color.set(themeColour(`--figure-${side}`));
      this.shoe[side].color.set(themeColour(`--${side}`));
      this.shoe[side].emissive.set(themeColour(`--${side}`));
    }
  }

  /** Lights up the feet that are planted. */
  showPlanted(planted: Record<Side, boolean>): void {
    for (const side of ['left', 'right'] as const) this.shoe[side].emissiveIntensity = planted[side] ? 0.55 : 0;
  }

  dispose(): void {
    this.object.traverse((object) => object instanceof Mesh && (object.geometry as BufferGeometry).dispose());
    for (const material of [this.body, this.joint, ...Object.values(this.limb), ...Object.values(this.shoe)]) material.dispose();
  }

  private legLength(): number {
    const { motion } = this;
    const [hip, knee, ankle] = (['left_hip', 'left_knee', 'left_ankle'] as const).map((role) => motion.roles.get(role));
    if (hip === undefined || knee === undefined || ankle === undefined) return LEG_M;
    const at = (joint: number) => motion.position(0, joint);
    return at(hip).distanceTo(at(knee)) + at(knee).distanceTo(at(ankle));
  }

  private poseAt(frame: number): void {
    this.motion.pose(frame * this.motion.frameTime);
    this.object.updateMatrixWorld(true);
  }

  private attach(bone: Bone, geometry: BufferGeometry, material: MeshStandardMaterial): void {
    bone.add(new Mesh(geometry, material));
  }

  /** Where a role's joint is, in the frame of a bone, at the posed frame. */
  private seenFrom(bone: Bone, role: Role): Vector3 | undefined {
    const other = this.motion.bone(role);
    return other && bone.worldToLocal(other.getWorldPosition(new Vector3()));
  }

  /** Everything on the way from a bone up to an ancestor is shown by some mesh. */
  private coverChain(from: Bone | undefined, ancestor: Bone | undefined): void {
    for (let bone = from; bone && bone !== ancestor; bone = bone.parent as Bone) this.drawn.add(bone);
  }

  private buildTrunk(frame: number): void {
    const { motion, size } = this;
    const hips = motion.bone('hips');
    const chest = motion.bone('chest');
    const neck = motion.bone('neck') ?? motion.bone('head');
    if (!hips || !chest || !neck) return;
    const balls = (bone: Bone, parts: [Role, number][]): Ball[] =>
      parts.flatMap(([role, radius]) => {
        const at = this.seenFrom(bone, role);
        return at ? [{ at, radius: radius * size }] : [];
      });
    const pelvis = balls(hips, [['hips', 0.09], ['left_hip', 0.082], ['right_hip', 0.082], ['spine', 0.085]]);
    this.attach(hips, hull(pelvis), this.body);
    const thorax = balls(chest, [['left_shoulder', 0.055], ['right_shoulder', 0.055]]);
    const nape = this.seenFrom(chest, neck === motion.bone('neck') ? 'neck' : 'head');
    if (nape) {
      thorax.push({ at: nape.clone().multiplyScalar(0.94), radius: 0.05 * size });
      // The rib cage hangs below the neck; the joint called chest may sit anywhere between waist and neck.
      const down = this.seenFrom(chest, 'hips')!.sub(nape).normalize();
      thorax.push({ at: nape.clone().addScaledVector(down, 0.13 * size), radius: 0.118 * size });
      thorax.push({ at: nape.clone().addScaledVector(down, 0.21 * size), radius: 0.105 * size });
    }
    this.attach(chest, hull(thorax), this.body);
    // The waist: one capsule for each link of the spine, so that it bends.
    for (let bone = chest; bone !== hips && bone.parent instanceof Bone; bone = bone.parent) {
      if (bone.position.length() > 1e-4) {
        // Where the chest's joint lies up at the neck, a wide end would stand out of the breast.
        const high = bone === chest && nape !== undefined && nape.length() < 0.08 * size;
        this.attach(bone.parent, taperedCapsule(new Vector3(), bone.position, 0.092 * size, (high ? 0.05 : 0.1) * size), this.body);
      }
    }
    this.coverChain(chest, hips);
    this.coverChain(neck, chest);
    for (const side of ['left', 'right'] as const) {
      this.coverChain(motion.bone(`${side}_shoulder`), chest);
      this.coverChain(motion.bone(`${side}_hip`), hips);
    }
    this.buildHead(neck, frame);
  }

  private buildHead(neck: Bone, frame: number): void {
    const { motion, size } = this;
    const head = motion.bone('head');
    if (!head) return;
    if (head !== neck) {
      const top = this.seenFrom(neck, 'head')!;
      this.attach(neck, taperedCapsule(new Vector3(), top, 0.052 * size, 0.048 * size), this.body);
      this.coverChain(head, neck);
    }
    // Axes of the head in its own frame: up along the neck as it stands, forward as the pelvis faces.
    const toLocal = head.getWorldQuaternion(new Quaternion()).invert();
    const up = new Vector3(0, 1, 0);
    if (head !== neck) {
      up.add(head.getWorldPosition(new Vector3()).sub(neck.getWorldPosition(new Vector3())).normalize()).normalize();
    }
    const forward = motion.facing(frame);
    forward.addScaledVector(up, -forward.dot(up)).normalize();
    const centre = up.clone().multiplyScalar(0.1 * size).addScaledVector(forward, 0.02 * size);
    const place = (x: Vector3) => x.clone().applyQuaternion(toLocal);
    const skull: Ball[] = [
      { at: place(centre.clone().addScaledVector(up, 0.025 * size).addScaledVector(forward, -0.012 * size)), radius: 0.083 * size },
      { at: place(centre.clone().addScaledVector(up, -0.05 * size).addScaledVector(forward, 0.028 * size)), radius: 0.052 * size },
    ];
    this.attach(head, hull(skull), this.body);
    const visor = new SphereGeometry(0.058 * size, 20, 14).scale(1, 0.62, 0.62);
    const turn = new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), forward);
    const at = centre.clone().addScaledVector(forward, 0.048 * size).addScaledVector(up, 0.012 * size);
    this.attach(head, visor.applyQuaternion(turn).translate(at.x, at.y, at.z).applyQuaternion(toLocal), this.joint);
    head.traverse((bone) => bone instanceof Bone && this.drawn.add(bone));
  }

  private buildLimb(side: Side, part: string, lower: string, from: number, to: number): void {
    const { motion, size } = this;
    const upper = motion.bone(`${side}_${part}` as Role);
    const end = this.motion.bone(`${side}_${lower}` as Role);
    if (!upper || !end) return;
    const tip = this.seenFrom(upper, `${side}_${lower}` as Role)!;
    this.attach(upper, taperedCapsule(new Vector3(), tip, from * size, to * size), this.limb[side]);
    // Knees and elbows show as joints; hips and shoulders lie within the trunk.
    if (part === 'knee' || part === 'elbow') this.attach(upper, new SphereGeometry(from * 1.04 * size, 20, 14), this.joint);
    this.coverChain(end, upper);
  }

  private buildHand(side: Side): void {
    const { motion, size } = this;
    const wrist = motion.bone(`${side}_wrist`);
    if (!wrist || !motion.bone(`${side}_elbow`)) return;
    const along = this.seenFrom(wrist, `${side}_elbow`)!.negate().normalize();
    const at = (distance: number, radius: number) => ({ at: along.clone().multiplyScalar(distance * size), radius: radius * size });
    this.attach(wrist, hull([at(0, 0.026), at(0.055, 0.034), at(0.11, 0.018)]), this.joint);
    wrist.traverse((bone) => bone instanceof Bone && this.drawn.add(bone));
  }

  /** A shoe, shaped where the foot stands flattest so that its sole lies on the floor. */
  private buildFoot(side: Side, contacts: Contact[]): void {
    const { motion, size } = this;
    const ankle = motion.bone(`${side}_ankle`);
    const toe = motion.bone(`${side}_toe`);
    if (!ankle || !toe) return;
    const flat = this.flattestFrame(side, contacts);
    this.poseAt(flat);
    const ankleAt = ankle.getWorldPosition(new Vector3());
    const ballAt = toe.getWorldPosition(new Vector3());
    const forward = ballAt.clone().sub(ankleAt).setY(0).normalize();
    const across = new Vector3(0, 1, 0).cross(forward);
    const floor = Math.abs(ballAt.y) < 0.12 * size ? 0 : ballAt.y - 0.03 * size;
    const point = (origin: Vector3, ahead: number, aside: number, y: number) =>
      origin.clone().addScaledVector(forward, ahead * size).addScaledVector(across, aside * size).setY(y);
    const sole = (origin: Vector3, ahead: number, half: number): Ball[] =>
      [-half, half].map((aside) => ({ at: point(origin, ahead, aside, floor + 0.002), radius: 0 }));
    const upper = Math.min(0.03 * size, Math.max(0.012 * size, ballAt.y - floor));
    const instep: Ball[] = [
      { at: ankleAt, radius: 0.04 * size },
      { at: point(ankleAt, -0.035, 0, floor + 0.045 * size), radius: 0.034 * size },
      { at: point(ballAt, 0, 0.018, floor + upper), radius: upper * 0.95 },
      { at: point(ballAt, 0, -0.018, floor + upper), radius: upper * 0.95 },
      ...sole(ankleAt, -0.06, 0.022), ...sole(ankleAt, 0, 0.03), ...sole(ballAt, 0, 0.042),
    ];
    const front: Ball[] = [
      { at: point(ballAt, 0, 0.018, floor + upper), radius: upper * 0.95 },
      { at: point(ballAt, 0, -0.018, floor + upper), radius: upper * 0.95 },
      { at: point(ballAt, 0.05, 0, floor + upper * 0.75), radius: upper * 0.7 },
      ...sole(ballAt, 0, 0.042), ...sole(ballAt, 0.055, 0.034), ...sole(ballAt, 0.08, 0.014),
    ];
    const local = (bone: Bone, balls: Ball[]) => balls.map(({ at, radius }) => ({ at: bone.worldToLocal(at.clone()), radius }));
    this.attach(ankle, hull(local(ankle, instep)), this.shoe[side]);
    this.attach(toe, hull(local(toe, front)), this.shoe[side]);
    ankle.traverse((bone) => bone instanceof Bone && this.drawn.add(bone));
  }

  private flattestFrame(side: Side, contacts: Contact[]): number {
    const ankle = this.motion.roles.get(`${side}_ankle`)!;
    const height = (frame: number) => this.motion.position(frame, ankle).y;
    let best = 0;
    let bestFrame = 0;
    const planted = contacts.filter((contact) => contact.foot === side);
    const isPlanted = (frame: number) => planted.some(({ from, to }) => from <= frame && frame <= to);
    for (let frame = 0; frame < this.motion.frames; ++frame) {
      const score = -height(frame) + (isPlanted(frame) ? 10 : 0);
      if (frame === 0 || score > best) [best, bestFrame] = [score, frame];
    }
    return bestFrame;
  }

  /** Whatever has no role, such as something carried: a thin rod, so that nothing in the file stays unseen. */
  private buildRest(): void {
    for (const bone of this.motion.bones) {
      const above = bone.parent;
      const held = (bone.name !== 'ENDSITE' && bone !== this.motion.bone('hips')) && !this.drawn.has(bone);
      if (above instanceof Bone && held && bone.position.length() > 0.01) {
        this.attach(above, taperedCapsule(new Vector3(), bone.position, 0.016 * this.size, 0.012 * this.size), this.joint);
      }
    }
  }
}
