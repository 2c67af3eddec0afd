#!/usr/bin/env python3
"""Renders a BVH clip as a contact sheet of stick figures, so that a motion can be looked at in one picture.

    render_clip.py CLIP.bvh [--out CLIP.png] [--from S] [--to S] [--figures 16]

Rows: figures from their left side and from the front at even times (turned to the pelvis heading, so that turns do not
foreshorten them); every frame's feet as seen from the side, enlarged; heights and speeds of ankles and balls of the feet; and,
on the right, the walk from above. Left limbs are red, right limbs blue; a foot is drawn bold while its ball is low and slow.
Needs numpy and matplotlib (Debian: python3-matplotlib).
"""

import argparse
import pathlib
import re

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

LEFT, RIGHT, BODY = "#c8322c", "#2a5fc4", "#50555c"
# Metres per unit met in the wild; the one that gives a person's height is taken.
UNITS_M = (1.0, 0.01, 0.001, 0.0254, 0.0254 / 0.45)
STANDING_HEIGHT_M = 1.65
STRIDE_M = 1.0  # between the figures of a row


class Clip:
    """A BVH file: joint names, parents, and world positions (frames, joints, 3) in metres."""

    def __init__(self, path):
        tokens = pathlib.Path(path).read_text(encoding="utf-8-sig").split()
        self.names, self.parents, offsets, channels, stack = [], [], [], [], []
        i = 1
        while tokens[i] != "MOTION":
            word = tokens[i]
            if word in ("ROOT", "JOINT", "End"):
                self.names.append(tokens[i + 1] if word != "End" else self.names[stack[-1]] + ".end")
                self.parents.append(stack[-1] if stack else -1)
                channels.append([])
                offsets.append(np.zeros(3))
                i += 2
            elif word == "{":
                stack.append(len(self.names) - 1)
                i += 1
            elif word == "}":
                stack.pop()
                i += 1
            elif word == "OFFSET":
                offsets[-1] = np.array(tokens[i + 1 : i + 4], float)
                i += 4
            elif word == "CHANNELS":
                count = int(tokens[i + 1])
                channels[-1] = tokens[i + 2 : i + 2 + count]
                i += 2 + count
            else:
                raise SystemExit(f"{path}: unexpected '{word}' in the hierarchy")
        header = " ".join(tokens[i : i + 8])
        match = re.match(r"MOTION Frames ?: ?(\d+) Frame Time ?: ?(\S+)", header)
        if not match:
            raise SystemExit(f"{path}: no frame count and frame time after MOTION")
        frames, self.frame_time_s = int(match[1]), float(match[2])
        width = sum(map(len, channels))
        values = np.array(tokens[len(tokens) - frames * width :], float).reshape(frames, width)
        self.positions_m = self._forward_kinematics(np.array(offsets), channels, values)
        height = np.median(np.ptp(self.positions_m[:, :, 1], axis=1))
        self.metres_per_unit = min(UNITS_M, key=lambda m: abs(np.log(m * height / STANDING_HEIGHT_M)))
        self.positions_m *= self.metres_per_unit

    def _forward_kinematics(self, offsets, channels, values):
        frames = len(values)
        world = np.empty((frames, len(self.names), 3))
        rotations = np.empty((len(self.names), frames, 3, 3))
        column = 0
        for joint, parent in enumerate(self.parents):
            local = np.tile(offsets[joint], (frames, 1))
            rotation = np.tile(np.eye(3), (frames, 1, 1))
            for channel in channels[joint]:
                axis = "XYZ".index(channel[0].upper())
                if channel.lower().endswith("position"):
                    local[:, axis] = values[:, column]  # replaces the OFFSET
                else:
                    rotation = rotation @ axis_rotation(axis, np.radians(values[:, column]))
                column += 1
            if parent < 0:
                world[:, joint], rotations[joint] = local, rotation
            else:
                world[:, joint] = world[:, parent] + np.einsum("fij,fj->fi", rotations[parent], local)
                rotations[joint] = rotations[parent] @ rotation
        return world

    def joint(self, *patterns):
        """First joint whose lower-case letters match a pattern, patterns in order of preference."""
        for pattern in patterns:
            for index, name in enumerate(self.names):
                if re.fullmatch(pattern, re.sub("[^a-z]", "", name.split(":")[-1].lower())):
                    return index
        raise SystemExit(f"no joint matches {patterns}; joints: {', '.join(self.names)}")


def axis_rotation(axis, angle):
    rotation = np.zeros((len(angle), 3, 3))
    a, b = (axis + 1) % 3, (axis + 2) % 3
    rotation[:, axis, axis] = 1
    rotation[:, a, a] = rotation[:, b, b] = np.cos(angle)
    rotation[:, b, a], rotation[:, a, b] = np.sin(angle), -np.sin(angle)
    return rotation


def find_feet(clip):
    feet = {}
    for side, letter, colour in (("left", "l", LEFT), ("right", "r", RIGHT)):
        feet[side] = {
            "hip": clip.joint(f"{side}upleg", f"{side}hip", f"upperleg{letter}"),
            "ankle": clip.joint(f"{side}foot", f"{side}ankle", f"foot{letter}"),
            "ball": clip.joint(f"{side}toebase", f"{side}toe", f"toes{letter}"),
            "colour": colour,
        }
    return feet


def limb_colour(name):
    word = name.split(":")[-1]
    if re.search(r"left|^l[A-Z]|_l(\.|$)", word, re.I if "left" in word.lower() or "_" in word else 0):
        return LEFT
    if re.search(r"right|^r[A-Z]|_r(\.|$)", word, re.I if "right" in word.lower() or "_" in word else 0):
        return RIGHT
    return BODY


def speeds(points, frame_time_s):
    return np.linalg.norm(np.gradient(points, frame_time_s, axis=0), axis=1)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("clip")
    parser.add_argument("--out")
    parser.add_argument("--from", dest="start", type=float, default=0.0, help="seconds")
    parser.add_argument("--to", dest="end", type=float, default=1e9, help="seconds")
    parser.add_argument("--figures", type=int, default=16)
    options = parser.parse_args()

    clip = Clip(options.clip)
    dt = clip.frame_time_s
    first = int(options.start / dt)
    last = min(len(clip.positions_m), int(options.end / dt) + 1)
    if last - first < 2:
        raise SystemExit("fewer than 2 frames in the asked interval")
    p = clip.positions_m[first:last]
    feet = find_feet(clip)
    left_hip, right_hip = feet["left"]["hip"], feet["right"]["hip"]
    hips = (p[:, left_hip] + p[:, right_hip]) / 2

    # Facing = (left hip - right hip) x up, on the floor.
    side = p[:, left_hip] - p[:, right_hip]
    facing = np.cross(side, [0.0, 1.0, 0.0])
    facing /= np.linalg.norm(facing, axis=1, keepdims=True)
    across = np.cross([0.0, 1.0, 0.0], facing)  # to the left of the body
    ground = np.percentile(p[:, [feet["left"]["ball"], feet["right"]["ball"]], 1], 2)
    moving = [j for j in range(len(clip.names)) if np.ptp(clip.positions_m[:, j], axis=0).max() > 0]  # a static root is no bone
    bones = [(j, q) for j, q in enumerate(clip.parents) if j in moving and q in moving]
    colours = [limb_colour(clip.names[j]) for j, _ in bones]
    time = (first + np.arange(len(p))) * dt

    figure = plt.figure(figsize=(20, 10.5), dpi=90)
    grid = figure.add_gridspec(4, 2, width_ratios=[4, 1], height_ratios=[2.1, 2.1, 1.5, 2.2],
                               hspace=0.22, wspace=0.08, top=0.94, bottom=0.05, left=0.03, right=0.99)
    chosen = np.linspace(0, len(p) - 1, min(options.figures, len(p))).round().astype(int)
    for row, (axis, title) in enumerate(((facing, "from the left side (faces right)"), (-across, "from behind"))):
        view = figure.add_subplot(grid[row, 0])
        for cell, frame in enumerate(chosen):
            flat = np.stack([(p[frame] - hips[frame]) @ axis[frame] + cell * STRIDE_M, p[frame, :, 1] - ground], axis=1)
            for (j, q), colour in zip(bones, colours):
                view.plot(*flat[[j, q]].T, color=colour, lw=2, solid_capstyle="round")
            view.text(cell * STRIDE_M, -0.16, f"{first + frame}", ha="center", fontsize=8)
        view.axhline(0, color="0.6", lw=0.8)
        view.set(aspect="equal", title=title, ylim=(-0.25, 1.95), xlim=(-0.7, len(chosen) * STRIDE_M - 0.4), yticks=[], xticks=[])

    # Feet from the side: distance walked along the path against height, enlarged.
    travelled = np.concatenate([[0], np.cumsum(np.sum(np.diff(hips, axis=0) * facing[1:], axis=1))])
    view = figure.add_subplot(grid[2, 0])
    plots = figure.add_subplot(grid[3, 0])
    speed_plot = plots.twinx()
    above = figure.add_subplot(grid[:, 1])
    for name, foot in feet.items():
        ankle, ball = p[:, foot["ankle"]], p[:, foot["ball"]]
        planted = (ball[:, 1] - ground < 0.03) & (speeds(ball, dt) < 0.35)
        ends = [j for j, q in enumerate(clip.parents) if q == foot["ball"]]
        chain = [foot["ankle"], foot["ball"]] + ends[:1]
        for frame in range(0, len(p), max(1, round(1 / 30 / dt))):
            x = travelled[frame] + (p[frame, chain] - hips[frame]) @ facing[frame]
            view.plot(x, p[frame, chain, 1] - ground, color=foot["colour"],
                      lw=1.6 if planted[frame] else 0.5, alpha=0.9 if planted[frame] else 0.45)
        plots.plot(time, (ankle[:, 1] - ground) * 100, color=foot["colour"], lw=0.8, ls=":", label=f"{name} ankle")
        plots.plot(time, (ball[:, 1] - ground) * 100, color=foot["colour"], lw=1.4, label=f"{name} ball")
        speed_plot.plot(time, speeds(ball, dt), color=foot["colour"], lw=0.6, ls="--")
        plots.fill_between(time, -3, -1 if name == "left" else -2, where=planted, color=foot["colour"], alpha=0.5, lw=0)
        above.plot(ball[:, 0], ball[:, 2], color=foot["colour"], lw=0.5)
        above.plot(ball[planted, 0], ball[planted, 2], ".", color=foot["colour"], ms=6)
    view.axhline(0, color="0.6", lw=0.8)
    view.set(title="feet, side view (m; bold while low and slow)", ylim=(-0.05, 0.35), aspect="auto")
    plots.set(title="height of balls and ankles, cm (solid, dotted); speed of balls, m/s (dashed)", xlabel="time, s", ylim=(-3, 40))
    plots.legend(fontsize=7, ncol=4, loc="upper right")
    plots.grid(alpha=0.3)
    above.plot(hips[:, 0], hips[:, 2], color=BODY, lw=1.5)
    above.plot(*hips[0, [0, 2]], "o", color=BODY)
    arrows = slice(0, len(p), max(1, round(0.5 / dt)))
    above.quiver(hips[arrows, 0], hips[arrows, 2], facing[arrows, 0], facing[arrows, 2], color=BODY, width=0.004, scale=18)
    # Seen from above, drawn with +X to the left, so that left stays left when walking along +Z (up the page).
    middle, half = np.mean([hips.max(axis=0), hips.min(axis=0)], axis=0), np.ptp(hips, axis=0) / 2 + 0.5
    half = np.maximum(half, half.max() / 3.2)
    above.set(aspect="equal", title="from above, x and z in m", xlim=(middle[0] + half[0], middle[0] - half[0]),
              ylim=(middle[2] - half[2], middle[2] + half[2]))
    above.grid(alpha=0.3)

    root_speed = speeds(hips * [1, 0, 1], dt)
    below = (ground - p[:, moving, 1].min()) * 100
    figure.suptitle(
        f"{pathlib.Path(options.clip).name}: {len(p)} of {len(clip.positions_m)} frames at {1 / dt:.4g} fps, "
        f"{clip.metres_per_unit:.4g} m per unit; root {np.median(root_speed):.2f} m/s, lowest joint {below:.1f} cm below the balls' floor")
    out = options.out or str(pathlib.Path(options.clip).with_suffix(".png").name)
    figure.savefig(out)
    print(out)


if __name__ == "__main__":
    main()
