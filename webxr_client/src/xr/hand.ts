/** One controller or hand as it is at this moment: poses in the scene, buttons as switches. */
import { Group, Matrix4, Quaternion, Vector3 } from 'three';
import { pulse } from './actuators';
import { chords, deviceFor, type Device, type PadPlace } from './devices';
import { readPad, Repeat, Switch, takeChord, type Chord, type Pad } from './pad';
import type { Poses } from './poses';
import { Pressure } from './pressure';
import type { Side } from './settings';
import { turnBy } from './vectors';

/** A pinch without a gamepad counts as a trigger pressed so far. */
const PINCHED = 1;

export class Hand {
  /** Follows the grip; a child of the rig, so in the headset's own space. */
  readonly grip = new Group();
  source: XRInputSource | null = null;
  device: Device | null = null;
  /** It was seen in this frame. */
  tracked = false;
  /** The pointing ray, in the scene. */
  readonly origin = new Vector3();
  readonly direction = new Vector3(0, 0, -1);
  /** Where it is held, in the scene. */
  readonly place = new Vector3();
  readonly turn = new Quaternion();
  /** Where thumb and index finger meet, in the scene; controllers have no such place. */
  readonly pinch = new Vector3();
  hasPinch = false;
  /** Metres from the ray's origin to the tip where the brush begins. */
  readonly tip = new Float64Array(1);
  trigger = 0;
  readonly pad: Pad = { x: 0, y: 0, click: false };
  readonly pressure = new Pressure();
  readonly click = new Switch();
  readonly squeeze = new Switch();
  readonly press = new Switch();
  readonly primary = new Switch();
  readonly secondary = new Switch();
  readonly leanUp = new Switch();
  readonly repeatX = new Repeat();
  readonly repeatY = new Repeat();
  /** Edges of this frame: 1 down, −1 up. */
  readonly edge = { click: 0, squeeze: 0, press: 0, primary: 0, secondary: 0 };
  /** The grip that is held was for the pad's buttons: it moves nothing until it is let go. */
  chorded = false;
  private readonly chord: Chord = { primary: 0, secondary: 0 };
  private pinching = false;
  private readonly matrix = new Matrix4();

  constructor(readonly side: Side) {
    this.grip.visible = false;
    this.grip.matrixAutoUpdate = false;
  }

  attach(source: XRInputSource): void {
    this.source = source;
    const axes = source.gamepad?.axes.length ?? 0;
    this.device = deviceFor(source.profiles, axes, Boolean(source.hand));
    this.tip[0] = this.device.tip;
  }

  detach(): void {
    this.source = null;
    this.device = null;
    this.tracked = false;
    this.pinching = this.hasPinch = false;
    this.grip.visible = false;
    this.rest();
  }

  /** Selecting, for hands that have no gamepad. */
  select(down: boolean): void {
    this.pinching = down;
  }

  /** It can take hold without painting or pointing. */
  get hasGrip(): boolean {
    return (this.device?.squeeze ?? -1) >= 0;
  }

  get isHand(): boolean {
    return this.device?.id === 'hand';
  }

  /** Take in this frame; `rig` is where the headset's space lies in the scene. */
  update(poses: Poses, rig: Matrix4): void {
    const { source, grip, matrix } = this;
    const number = this.side === 'left' ? 0 : 1;
    this.tracked = source !== null && poses.ray(number, matrix);
    if (!source || !this.tracked) {
      grip.visible = false;
      this.rest();
      return;
    }
    // Without a grip the ray's own origin is where it is held.
    if (!poses.grip(number, grip.matrix)) grip.matrix.copy(matrix);
    this.takePose(rig);
    this.readButtons(source.gamepad ?? null);
  }

  /** `matrix` is the ray's. */
  private takePose(rig: Matrix4): void {
    this.turn.setFromRotationMatrix(this.matrix);
    this.origin.setFromMatrixPosition(this.matrix).applyMatrix4(rig);
    const { elements } = this.matrix;
    const { direction } = this;
    // A ray points along −z.
    direction.x = -elements[8];
    direction.y = -elements[9];
    direction.z = -elements[10];
    turnBy(rig, direction, direction);
    this.grip.position.setFromMatrixPosition(this.grip.matrix);
    this.grip.matrixWorldNeedsUpdate = true;
    this.grip.visible = true;
    this.place.setFromMatrixPosition(this.matrix.multiplyMatrices(rig, this.grip.matrix));
  }

  private readButtons(gamepad: Gamepad | null): void {
    const device = this.device!;
    const pinched = this.pinching ? PINCHED : 0;
    this.trigger = Math.max(value(gamepad, device.trigger), this.isHand ? pinched : 0);
    readThumb(device, gamepad, this.pad);
    const { edge, pad } = this;
    const idle = pad.x === 0 && pad.y === 0 && !pad.click;
    if (idle && device.second) readThumb(device.second, gamepad, pad);
    edge.click = this.click.update(this.trigger);
    edge.squeeze = this.squeeze.update(value(gamepad, device.squeeze));
    this.readChord(gamepad);
    edge.press = this.press.update(this.pad.click ? 1 : 0);
    edge.primary = this.primary.update(this.chord.primary);
    edge.secondary = this.secondary.update(this.chord.secondary);
  }

  /** Two buttons: its own, or the pad's while the grip is held. */
  private readChord(gamepad: Gamepad | null): void {
    const { chord, squeeze } = this;
    const device = this.device!;
    if (!squeeze.down) this.chorded = false;
    if (chords(device) && squeeze.down) {
      takeChord(this.pad, chord);
      if (chord.primary > 0 || chord.secondary > 0) this.chorded = true;
      return;
    }
    chord.primary = value(gamepad, device.primary);
    chord.secondary = value(gamepad, device.secondary);
  }

  /** Nothing is pressed on a controller that is not there. */
  private rest(): void {
    const { edge, pad } = this;
    this.trigger = pad.x = pad.y = 0;
    pad.click = this.chorded = false;
    edge.click = this.click.update(0);
    edge.squeeze = this.squeeze.update(0);
    edge.press = this.press.update(0);
    edge.primary = this.primary.update(0);
    edge.secondary = this.secondary.update(0);
  }

  /** A felt pulse; strength 0..1. */
  pulse(strength: number, milliseconds: number): void {
    pulse(this.source?.gamepad, strength, milliseconds);
  }
}

function readThumb({ pad, axes, press }: PadPlace, gamepad: Gamepad | null, out: Pad): void {
  // Absent axes are null in some runtimes.
  const x = gamepad?.axes[axes[0]] || 0;
  const y = gamepad?.axes[axes[1]] || 0;
  readPad(pad, x, y, value(gamepad, press) > 0.5, out);
}

function value(gamepad: Gamepad | null, button: number): number {
  return gamepad && button >= 0 ? (gamepad.buttons[button]?.value ?? 0) : 0;
}
