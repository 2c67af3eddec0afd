// Puts a clip on the stage: figure, path and foot prints, kept at the moment of the player; what was asked for on the floor; and variants.
import type { Report, VariantSummary } from './api_client';
import type { ClipMotion } from './clip_motion';
import { ControlMarks } from './control_marks';
import type { Control } from './controls';
import { Figure } from './figure';
import { FloorMarks } from './floor_marks';
import { Ghosts } from './ghosts';
import type { Player } from './player';
import type { Stage, View } from './stage';
import { onTheme } from './theme';

export class ClipScene {
  private motion?: ClipMotion;
  private report?: Report;
  private figure?: Figure;
  private marks?: FloorMarks;
  private readonly asked = new ControlMarks();
  private readonly ghosts = new Ghosts();

  constructor(private readonly stage: Stage, private readonly player: Player) {
    stage.add(this.asked.object);
    stage.add(this.ghosts.object);
    player.onChange(() => this.update());
    onTheme(() => {
      this.asked.recolour();
      this.ghosts.recolour();
      this.figure?.recolour();
      this.marks?.recolour();
      stage.invalidate();
    });
  }

  load(motion: ClipMotion, report: Report): void {
    for (const part of [this.figure, this.marks]) {
      if (part) this.stage.remove(part.object);
      part?.dispose();
    }
    this.motion = motion;
    this.report = report;
    this.figure = new Figure(motion, report.contacts);
    this.marks = new FloorMarks(motion, report.path, report.contacts);
    this.stage.add(this.figure.object);
    this.stage.add(this.marks.object);
    this.update();
  }

  /** Shows what is asked for on the floor. */
  showControls(controls: Control[]): void {
    this.asked.show(controls);
    this.stage.invalidate();
  }

  addGhost(motion: ClipMotion): void {
    this.ghosts.add(motion);
    this.update();
  }

  showSweptArea(area: VariantSummary['swept_area']): void {
    this.ghosts.showArea(area);
    this.stage.invalidate();
  }

  clearGhosts(): void {
    this.ghosts.clear();
    this.stage.invalidate();
  }

  get ghostCount(): number {
    return this.ghosts.count;
  }

  look(view: View): void {
    if (this.motion) this.stage.look(view, this.motion.facing(this.player.frame));
  }

  private update(): void {
    const { motion, report, figure, marks, player } = this;
    if (!motion || !report || !figure || !marks) return;
    motion.pose(player.time);
    const planted = (foot: 'left' | 'right') =>
      report.contacts.some((contact) => contact.foot === foot && contact.from <= player.frame && player.frame <= contact.to);
    figure.showPlanted({ left: planted('left'), right: planted('right') });
    const hips = motion.bone('hips') ?? motion.root;
    hips.updateWorldMatrix(true, false);
    const [x, z] = [hips.matrixWorld.elements[12], hips.matrixWorld.elements[14]];
    marks.show(player.frame, x, z);
    this.ghosts.pose(player.time);
    this.stage.moveFocus(x, z);
  }
}
