/** One input source as it is at this moment: poses in the scene, buttons as switches. */
import { Group, Matrix4, Quaternion, Vector3 } from 'three';
import { pulse } from './haptics';
import { chords, type Device, type PadPlace } from './devices';
import { buttonValue, type Kind, type Reach } from './kind';
import { idlePad, Repeat, Switch, takeChord, Thumb, type Chord, type Pad } from './pad';
import { pinchesForSystem, type Eyes } from './palm';
import type { Poses } from './poses';
import { Pressure } from './pressure';
import type { Present } from './roles';
import type { Side } from '../../store/xr-settings';
import { turnBy } from '../drawing/vectors';

/** Pressure below which a trigger counts as released. */
const RELEASED = 0.1;
/** Metres along the ray at which a far pointer works before anything was hit. */
const DEPTH = 1.5;

export class Pointer implements Present {
  /** Follows the grip; a child of the rig, so in the headset's own space. */
  readonly grip = new Group();
  readonly device: Device;
  readonly side: Side | 'none';
  /** It was seen in this frame. */
  tracked = false;
  /** It was seen released since it came, came back or jumped: until then nothing is pressed. */
  armed: boolean;
  /** It has gone, and its last press is still to be seen. */
  leaving = false;
  /** The pointing ray, in the scene. */
  readonly origin = new Vector3();
  readonly direction = new Vector3(0, 0, -1);
  /** Place of the hand, in the scene; else where its ray begins, or ends if it points from afar. */
  readonly place = new Vector3();
  readonly turn = new Quaternion();
  /** Meeting point of thumb and index finger, in the scene; controllers have no such place. */
  readonly pinch = new Vector3();
  hasPinch = false;
  /** The tip of the index finger, in the scene. */
  readonly fingertip = new Vector3();
  hasFingertip = false;
  /** Metres from the ray's origin to the tip where the brush begins. */
  readonly tip = new Float64Array(1);
  /** Metres along the ray at which a far pointer works. */
  readonly depth = Float64Array.of(DEPTH);
  /** Depth of its press, 0..1; 0 until it is armed. */
  trigger = 0;
  /** It is pressed, armed or not. */
  pinching = false;
  private palmTurned = false;
  /** It is pressed at a position that the headset only estimates; false for rays from the eyes. */
  guessed = false;
  readonly pad = idlePad();
  readonly pressure = new Pressure();
  readonly click = new Switch();
  readonly squeeze = new Switch();
  readonly press = new Switch();
  readonly primaryButton = new Switch();
  readonly secondaryButton = new Switch();
  readonly repeatX = new Repeat();
  readonly repeatSize = new Repeat();
  /** Lean of the pad while the grip is held, for the brush's size. */
  sizes = 0;
  /** Edges of this frame: 1 down, −1 up. */
  readonly edge = { click: 0, squeeze: 0, press: 0, primary: 0, secondary: 0 };
  /** The grip that is held was for the pad's buttons: it moves nothing until it is let go. */
  chorded = false;
  /** A push that began while the grip was held is a chord until the thumb lets go. */
  private push: 'none' | 'plain' | 'chord' = 'none';
  private readonly chord: Chord = { primary: 0, secondary: 0, size: 0 };
  private readonly thumb = new Thumb();
  private readonly secondThumb = new Thumb();
  private readonly second = idlePad();
  /** Between `selectstart` and `selectend`; a press shorter than a picture is seen in one. */
  private selecting = false;
  private selectSeen = true;
  private selectEnds = false;
  private readonly matrix = new Matrix4();

  constructor(
    readonly source: XRInputSource,
    readonly kind: Kind,
    readonly rank: number,
    /** It can press; inputs that are only tracked cannot. */
    readonly primary: boolean,
    /** Its number among the poses. */
    readonly input: number,
  ) {
    this.device = kind.device(source);
    this.side = source.handedness === 'left' || source.handedness === 'right' ? source.handedness : 'none'; // prettier-ignore
    this.tip[0] = this.device.tip;
    // An input that comes in order to press was released before.
    this.armed = kind.momentary;
    this.grip.visible = false;
    this.grip.matrixAutoUpdate = false;
  }

  get momentary(): boolean {
    return this.kind.momentary;
  }

  get holds(): boolean {
    return this.kind.holds;
  }

  get reach(): Reach {
    return this.kind.reach;
  }

  /** It can take hold without painting or pointing. */
  get hasGrip(): boolean {
    return this.device.squeeze >= 0;
  }

  /** `selectstart` and `selectend`. */
  select(down: boolean): void {
    if (down) {
      this.selecting = true;
      this.selectSeen = this.selectEnds = false;
    } else if (this.selectSeen) this.selecting = false;
    else this.selectEnds = true;
  }

  /** Its last press was seen, and its end. */
  get done(): boolean {
    return !this.tracked || (!this.selecting && !this.click.down);
  }

  /** Nothing is pressed until it was seen released. */
  disarm(): void {
    this.armed = false;
    this.trigger = 0;
  }

  /** Take in this frame; `rig` is where the headset's space lies in the scene. */
  update(poses: Poses, rig: Matrix4, eyes: Eyes): void {
    const { input, grip, matrix } = this;
    // An input that has gone lets go where it was seen last.
    if (!this.leaving) {
      const seen = poses.ray(input, matrix);
      if (!seen && this.tracked) this.armed = false;
      this.tracked = seen;
      if (seen) {
        // Without a grip the ray's own origin is where it is held.
        const held = poses.grip(input, grip.matrix);
        if (!held) grip.matrix.copy(matrix);
        this.takePose(rig, held);
        this.palmTurned =
          this.kind.systemPinch && held && pinchesForSystem(grip.matrix, this.side, eyes);
      }
    }
    grip.visible = this.tracked;
    if (this.tracked) this.readButtons(this.source.gamepad ?? null);
    else this.rest();
  }

  /** `matrix` is the ray's. */
  private takePose(rig: Matrix4, held: boolean): void {
    this.turn.setFromRotationMatrix(this.matrix);
    this.origin.setFromMatrixPosition(this.matrix).applyMatrix4(rig);
    const { elements } = this.matrix;
    const { direction, grip } = this;
    // A ray points along −z.
    direction.x = -elements[8];
    direction.y = -elements[9];
    direction.z = -elements[10];
    turnBy(rig, direction, direction);
    grip.position.setFromMatrixPosition(grip.matrix);
    grip.matrixWorldNeedsUpdate = true;
    this.place.setFromMatrixPosition(this.matrix.multiplyMatrices(rig, grip.matrix));
    if (!held && this.reach === 'far') this.along(this.place);
  }

  /** The place on the ray at which a far pointer works. */
  along(out: Vector3): void {
    const { origin, direction } = this;
    const distance = this.depth[0]!;
    out.x = origin.x + distance * direction.x;
    out.y = origin.y + distance * direction.y;
    out.z = origin.z + distance * direction.z;
  }

  private readButtons(gamepad: Gamepad | null): void {
    const { device, edge, pad } = this;
    const pressed = this.kind.press(gamepad, device, this.selecting);
    this.selectSeen = true;
    if (this.selectEnds) this.selecting = this.selectEnds = false;
    this.pinching = pressed >= RELEASED;
    // A pinch that begins with the palm turned to the eyes is the system's until it is let go.
    if (!this.pinching) this.armed = !this.palmTurned;
    this.trigger = this.armed ? pressed : 0;
    readThumb(this.thumb, device, gamepad, pad);
    this.sizes = 0;
    if (device.second) this.readSecond(device.second, gamepad);
    edge.click = this.click.update(this.trigger);
    edge.squeeze = this.squeeze.update(buttonValue(gamepad, device.squeeze));
    this.readChord(gamepad);
    edge.press = this.press.update(pad.click ? 1 : 0);
    edge.primary = this.primaryButton.update(this.chord.primary);
    edge.secondary = this.secondaryButton.update(this.chord.secondary);
  }

  /** Whether a press is at a place that is not known; asked only while one is held. */
  judge(poses: Poses, frame: XRFrame, space: XRReferenceSpace): void {
    const pressed = this.trigger > 0 && this.reach === 'near' && !this.leaving;
    this.guessed = pressed && poses.guessed(this.input, frame, space);
  }

  /** The touchpad beside a stick has the stick's functions. */
  private readSecond(place: PadPlace, gamepad: Gamepad | null): void {
    const { pad, second } = this;
    readThumb(this.secondThumb, place, gamepad, second);
    pad.touched ||= second.touched;
    const idle = pad.x === 0 && pad.y === 0 && !pad.click;
    if (!idle) return;
    pad.x = second.x;
    pad.y = second.y;
    pad.click = second.click;
  }

  /** Two buttons: its own, or the pad's while the grip is held. */
  private readChord(gamepad: Gamepad | null): void {
    const { chord, device, squeeze, pad } = this;
    chord.primary = chord.secondary = 0;
    if (!squeeze.down) this.chorded = false;
    if (pad.x === 0 && pad.y === 0 && !pad.click) this.push = 'none';
    else if (this.push === 'none') this.push = squeeze.down && chords(device) ? 'chord' : 'plain';
    if (this.push === 'chord') {
      takeChord(pad, chord);
      // Without the grip the rest of the push means nothing.
      if (!squeeze.down) chord.primary = chord.secondary = chord.size = 0;
      if (device.primary >= 0) chord.primary = 0;
      if (device.secondary >= 0) chord.secondary = 0;
      this.sizes = chord.size;
      if (chord.primary > 0 || chord.secondary > 0 || this.sizes !== 0) this.chorded = true;
    }
    if (device.primary >= 0) chord.primary = buttonValue(gamepad, device.primary);
    if (device.secondary >= 0) chord.secondary = buttonValue(gamepad, device.secondary);
  }

  /** Release all buttons of an absent source. */
  private rest(): void {
    const { edge, pad } = this;
    this.pinching = false;
    this.trigger = pad.x = pad.y = pad.over = this.sizes = 0;
    pad.click = pad.touched = this.chorded = false;
    this.thumb.rest();
    this.secondThumb.rest();
    edge.click = this.click.update(0);
    edge.squeeze = this.squeeze.update(0);
    edge.press = this.press.update(0);
    edge.primary = this.primaryButton.update(0);
    edge.secondary = this.secondaryButton.update(0);
  }

  /** Let it pulse, strength 0..1; false where nothing can be felt. */
  pulse(strength: number, milliseconds: number): boolean {
    return pulse(this.source.gamepad, strength, milliseconds);
  }
}

function readThumb(
  thumb: Thumb,
  { pad, axes, press }: PadPlace,
  gamepad: Gamepad | null,
  out: Pad,
): void {
  // Absent axes are null in some runtimes.
  const x = gamepad?.axes[axes[0]] || 0;
  const y = gamepad?.axes[axes[1]] || 0;
  const touched = press >= 0 && gamepad?.buttons[press]?.touched === true;
  thumb.read(pad, x, y, buttonValue(gamepad, press) > 0.5, touched, out);
}
