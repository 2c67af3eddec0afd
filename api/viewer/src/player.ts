// The clock of playback: a time within a clip that runs at a chosen speed. Knows nothing of what is drawn.

type Listener = (player: Player) => void;

export class Player {
  time = 0;
  speed = 1;
  playing = false;
  frames = 1;
  frameTime = 1 / 30;
  private readonly listeners: Listener[] = [];

  get duration(): number {
    return (this.frames - 1) * this.frameTime;
  }

  get frame(): number {
    return Math.min(this.frames - 1, Math.floor(this.time / this.frameTime + 1e-6));
  }

  onChange(listener: Listener): void {
    this.listeners.push(listener);
  }

  load(frames: number, frameTime: number): void {
    this.frames = frames;
    this.frameTime = frameTime;
    this.time = 0;
    this.changed();
  }

  toggle(playing = !this.playing): void {
    this.playing = playing;
    this.changed();
  }

  setSpeed(speed: number): void {
    this.speed = speed;
    this.changed();
  }

  seek(time: number): void {
    this.time = Math.min(Math.max(time, 0), this.duration);
    this.changed();
  }

  /** Stops and moves by whole frames. */
  stepFrames(count: number): void {
    this.playing = false;
    this.seek((this.frame + count) * this.frameTime);
  }

  /** Runs the clock for some seconds of real time; the clip starts again at its end. */
  advance(seconds: number): void {
    if (!this.playing || this.duration <= 0) return;
    this.time += seconds * this.speed;
    if (this.time > this.duration) this.time %= this.duration;
    this.changed();
  }

  private changed(): void {
    for (const listener of this.listeners) listener(this);
  }
}
