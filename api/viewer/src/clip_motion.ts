// A clip as read from BVH: the bones to pose, and the world positions of every joint at every frame.
import { Bone, Quaternion, Vector3 } from 'three';
import { BVHLoader } from 'three/addons/loaders/BVHLoader.js';
import { findRoles, type Role } from './joint_roles';

export class ClipMotion {
  readonly bones: Bone[];
  readonly parents: number[];
  readonly roles: Map<Role, number>;
  readonly frames: number;
  readonly frameTime: number;
  /** World positions in metres, [frame][joint][xyz], flat. */
  readonly positions: Float32Array;
  private readonly rotations: ArrayLike<number>[] = []; // of each bone, xyzw a frame; empty for end sites
  private readonly rootPositions: ArrayLike<number>;

  /** @throws Error when the text holds no motion with finite numbers. */
  constructor(bvh: string) {
    const { skeleton, clip } = new BVHLoader().parse(bvh);
    this.bones = skeleton.bones;
    this.parents = this.bones.map((bone) => this.bones.indexOf(bone.parent as Bone));
    this.roles = findRoles(this.bones.map((bone) => bone.name));
    // The loader writes a position and a rotation track for each bone but end sites, in the order of the bones. They are
    // read by place, not by name: names may repeat or hold characters that three.js would take for a path.
    let track = 0;
    for (const bone of this.bones) {
      if (bone.name === 'ENDSITE') {
        this.rotations.push([]);
      } else {
        this.rotations.push(clip.tracks[track + 1].values);
        track += 2;
      }
    }
    this.rootPositions = clip.tracks[0].values;
    this.frames = this.rootPositions.length / 3;
    this.frameTime = Number(/Frame Time\s*:\s*(\S+)/i.exec(bvh)?.[1]);
    this.positions = this.forwardKinematics();
    if (!(this.frames > 0) || !(this.frameTime > 0) || !this.positions.every(Number.isFinite)) {
      throw new Error('The clip holds no motion that could be played.');
    }
  }

  get duration(): number {
    return (this.frames - 1) * this.frameTime;
  }

  get root(): Bone {
    return this.bones[0];
  }

  bone(role: Role): Bone | undefined {
    const joint = this.roles.get(role);
    return joint === undefined ? undefined : this.bones[joint];
  }

  position(frame: number, joint: number, target = new Vector3()): Vector3 {
    return target.fromArray(this.positions, (frame * this.bones.length + joint) * 3);
  }

  /** Floor-plane direction that the pelvis faces: (left hip - right hip) x up. */
  facing(frame: number): Vector3 {
    const left = this.roles.get('left_hip');
    const right = this.roles.get('right_hip');
    if (left === undefined || right === undefined) return new Vector3(0, 0, 1);
    const across = this.position(frame, left).sub(this.position(frame, right));
    return across.cross(new Vector3(0, 1, 0)).setY(0).normalize();
  }

  /** Poses the bones at a time in seconds, between frames by spherical interpolation. */
  pose(time: number): void {
    const at = Math.min(Math.max(time / this.frameTime, 0), this.frames - 1);
    const from = Math.floor(at);
    const to = Math.min(from + 1, this.frames - 1);
    const part = at - from;
    const q = new Quaternion();
    this.bones.forEach((bone, joint) => {
      const values = this.rotations[joint];
      if (values.length === 0) return;
      bone.quaternion.fromArray(values, from * 4).slerp(q.fromArray(values, to * 4), part);
    });
    const p = new Vector3();
    this.root.position.fromArray(this.rootPositions, from * 3).lerp(p.fromArray(this.rootPositions, to * 3), part);
  }

  private forwardKinematics(): Float32Array {
    const count = this.bones.length;
    const positions = new Float32Array(this.frames * count * 3);
    const world = this.bones.map(() => new Quaternion());
    const points = this.bones.map(() => new Vector3());
    for (let frame = 0; frame < this.frames; ++frame) {
      for (let joint = 0; joint < count; ++joint) {
        const parent = this.parents[joint];
        if (parent < 0) {
          points[joint].fromArray(this.rootPositions, frame * 3);
          world[joint].fromArray(this.rotations[joint], frame * 4);
        } else {
          points[joint].copy(this.bones[joint].position).applyQuaternion(world[parent]).add(points[parent]);
          if (this.rotations[joint].length > 0) {
            world[joint].fromArray(this.rotations[joint], frame * 4).premultiply(world[parent]);
          }
        }
        points[joint].toArray(positions, (frame * count + joint) * 3);
      }
    }
    return positions;
  }
}
