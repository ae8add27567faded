/**
 * Poses of the head and the inputs in the headset's space, read into one array in each frame.
 * `XRFrame.fillPoses` (WebXR Hand Input) writes there itself; `getPose` makes objects for each.
 */
import type { Matrix4 } from 'three';

const HEAD = 0;
/** More inputs at once than hands, controllers and fingers on a screen are. */
const INPUTS = 8;
const RAYS = 1;
const GRIPS = RAYS + INPUTS;
const PLACES = GRIPS + INPUTS;

export class Poses {
  /** A column-major 4×4 for each place; NaN where nothing was seen. */
  private readonly values = new Float32Array(16 * PLACES).fill(NaN);
  /** Poses that are read, and the place of each. */
  private readonly spaces: XRSpace[] = [];
  private readonly places: number[] = [];
  private readonly taken: boolean[] = new Array<boolean>(INPUTS).fill(false);
  private readonly filled = new Float32Array(16 * PLACES);
  /** A position was known once: devices that know none, and emulators, call each a guess. */
  private knows = false;

  /** `head`: the session's viewer space. */
  constructor(head: XRSpace) {
    this.spaces.push(head);
    this.places.push(HEAD);
  }

  /** Read an input's spaces from now on, by the number that is returned; −1: there are too many. */
  add(source: XRInputSource): number {
    const input = this.taken.indexOf(false);
    if (input < 0) return -1;
    this.taken[input] = true;
    this.setPlace(RAYS + input, source.targetRaySpace);
    this.setPlace(GRIPS + input, source.gripSpace ?? null);
    return input;
  }

  /** An input has gone. */
  remove(input: number): void {
    this.taken[input] = false;
    this.setPlace(RAYS + input, null);
    this.setPlace(GRIPS + input, null);
  }

  private setPlace(place: number, space: XRSpace | null): void {
    const at = this.places.indexOf(place);
    if (at >= 0) {
      this.spaces.splice(at, 1);
      this.places.splice(at, 1);
      this.forget(place);
    }
    if (!space) return;
    this.spaces.push(space);
    this.places.push(place);
  }

  read(frame: XRFrame, base: XRReferenceSpace): void {
    if (!frame.fillPoses) {
      this.readOneByOne(frame, base);
      return;
    }
    frame.fillPoses(this.spaces, base, this.filled);
    const { places, filled, values } = this;
    for (let i = 0; i < places.length; i++) {
      const to = 16 * places[i]!;
      for (let k = 0; k < 16; k++) values[to + k] = filled[16 * i + k]!;
    }
  }

  private readOneByOne(frame: XRFrame, base: XRReferenceSpace): void {
    for (let i = 0; i < this.places.length; i++) {
      const place = this.places[i]!;
      const pose = frame.getPose(this.spaces[i]!, base);
      if (pose) this.values.set(pose.transform.matrix, 16 * place);
      else this.forget(place);
    }
  }

  private forget(place: number): void {
    this.values.fill(NaN, 16 * place, 16 * place + 16);
  }

  /** The head's pose; false when it is not known. */
  head(out: Matrix4): boolean {
    return this.take(HEAD, out);
  }

  /** An input's pointing ray: its origin, and its way along −z. */
  ray(input: number, out: Matrix4): boolean {
    return this.take(RAYS + input, out);
  }

  /**
   * Whether the headset only guesses where an input points from.  `fillPoses` does not tell, and a
   * pose costs objects: it is asked while something is pressed.
   */
  guessed(input: number, frame: XRFrame, base: XRReferenceSpace): boolean {
    const at = this.places.indexOf(RAYS + input);
    const pose = at < 0 ? undefined : frame.getPose(this.spaces[at]!, base);
    if (!pose) return false;
    if (!pose.emulatedPosition) this.knows = true;
    return pose.emulatedPosition && this.knows;
  }

  /** Pose by which an input is held. */
  grip(input: number, out: Matrix4): boolean {
    return this.take(GRIPS + input, out);
  }

  private take(place: number, out: Matrix4): boolean {
    const { values } = this;
    const { elements } = out;
    let seen = true;
    for (let k = 0; k < 16; k++) {
      const value = values[16 * place + k]!;
      elements[k] = value;
      // Only NaN fails both comparisons; a call of `Number` would box each value.
      seen &&= value >= 0 || value < 0;
    }
    return seen;
  }
}
