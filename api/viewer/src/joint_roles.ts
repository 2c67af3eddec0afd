// What a joint is in the body, whatever its skeleton calls it: the part of the server's table that drawing a figure needs.

export type Role =
  | 'hips' | 'spine' | 'chest' | 'neck' | 'head'
  | 'left_hip' | 'left_knee' | 'left_ankle' | 'left_toe' | 'left_shoulder' | 'left_elbow' | 'left_wrist'
  | 'right_hip' | 'right_knee' | 'right_ankle' | 'right_toe' | 'right_shoulder' | 'right_elbow' | 'right_wrist';

const MIDDLE: [Role, string[]][] = [
  ['hips', ['hips', 'hip', 'pelvis', 'root']],
  ['spine', ['spine', 'lowerback', 'spine0', 'chest', 'torso', 'abdomen']],
  ['chest', ['chest4', 'chest3', 'spine3', 'spine2', 'chest2', 'spine1', 'chest', 'thorax']],
  ['neck', ['neck', 'neck1']],
  ['head', ['head']],
];

// `#` stands for the letter of the side.
const SIDED: [string, string[]][] = [
  ['hip', ['#upleg', '#hip', 'upperleg#', '#thigh', 'thigh#', '#femur', '#upperleg']],
  ['knee', ['#knee', 'lowerleg#', '#leg', '#lowleg', '#shin', 'shin#', 'calf#', '#calf', '#tibia', '#lowerleg']],
  ['ankle', ['#ankle', 'foot#', '#foot']],
  ['toe', ['#toebase', '#toe', 'toes#', 'toe#', '#toes', '#ball', 'ball#']],
  ['shoulder', ['#arm', 'upperarm#', '#uparm', '#upperarm', '#humerus', '#shoulder', 'shoulder#']],
  ['elbow', ['#forearm', 'lowerarm#', '#elbow', '#lowarm', '#lowerarm', 'forearm#', '#radius']],
  ['wrist', ['#hand', 'hand#', '#wrist']],
];

function normalised(name: string): string {
  return name.slice(name.lastIndexOf(':') + 1).toLowerCase().replace(/[^a-z0-9]/g, '').replace('left', 'l').replace('right', 'r');
}

/** Index of the joint of every role that the skeleton has. */
export function findRoles(names: string[]): Map<Role, number> {
  const plain = names.map(normalised);
  const roles = new Map<Role, number>();
  const assign = (role: Role, wanted: string[]) => {
    for (const name of wanted) {
      const joint = plain.indexOf(name);
      if (joint >= 0) return void roles.set(role, joint);
    }
  };
  for (const [role, wanted] of MIDDLE) assign(role, wanted);
  for (const side of ['left', 'right']) {
    for (const [part, wanted] of SIDED) assign(`${side}_${part}` as Role, wanted.map((name) => name.replace('#', side[0])));
  }
  return roles;
}
