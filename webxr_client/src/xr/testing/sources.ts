/** For tests: input sources, their sessions and frames, as WebXR describes them. */
import { Matrix4, Scene } from 'three';
import { vi } from 'vitest';
import { Lessons } from '../input/lessons';
import { Pointers } from '../bodies/pointers';
import { Poses } from '../input/poses';
import { Rig } from '../moving/rig';

export interface SourceLook {
  readonly mode?: string;
  readonly side?: XRHandedness;
  readonly profile?: string;
  /** Instead of `profile`: all that the source names, the most specific first. */
  readonly profiles?: readonly string[];
  /** Joints are there. */
  readonly hand?: boolean;
  readonly axes?: number[];
  /** Positions that the gamepad's buttons have, null where it leaves one out; bare hands have none. */
  readonly buttons?: readonly (string | null)[];
}

/** A gamepad's button; held it is at 1. */
interface TestButton {
  value: number;
}

interface TestSpace {
  seen: boolean;
  guessed: boolean;
}

/** A source with poses and a trigger set by a test. */
export class TestSource {
  readonly targetRayMode: string;
  readonly handedness: XRHandedness;
  readonly profiles: readonly string[];
  readonly hand: ReadonlyMap<string, unknown> | undefined;
  readonly gamepad: { axes: number[]; buttons: (TestButton | null)[] } | undefined;
  readonly targetRaySpace: TestSpace;
  readonly gripSpace: TestSpace | undefined;
  seen = true;

  constructor(look: SourceLook) {
    const { mode = 'tracked-pointer', side = 'right', hand, axes = [] } = look;
    this.targetRayMode = mode;
    this.handedness = side;
    const usual = hand ? 'generic-hand-select' : 'generic-trigger-squeeze-touchpad';
    this.profiles = look.profiles ?? [look.profile ?? usual];
    this.hand = hand ? new Map() : undefined;
    const held = mode === 'tracked-pointer' && !hand;
    const names = look.buttons ?? (held ? Array.from({ length: 6 }, () => 'any') : null);
    const buttons = names?.map((name) => (name === null ? null : { value: 0 }));
    if (buttons) this.gamepad = { axes: [...axes], buttons };
    this.targetRaySpace = { seen: true, guessed: false };
    if (mode === 'tracked-pointer') this.gripSpace = this.targetRaySpace;
  }

  get xr(): XRInputSource {
    return this as unknown as XRInputSource;
  }

  set trigger(value: number) {
    this.press(0, value);
  }

  set squeeze(value: number) {
    this.press(1, value);
  }

  press(button: number, value: number): void {
    this.gamepad!.buttons[button]!.value = value;
  }

  /** Its position is a guess of the headset. */
  set guessed(value: boolean) {
    this.targetRaySpace.guessed = value;
  }

  set tracked(value: boolean) {
    this.targetRaySpace.seen = value;
  }
}

/** Every space that is seen lies at the origin. */
export const FRAME = {
  getPose: ({ seen, guessed }: TestSpace) => {
    const transform = { matrix: new Float32Array(new Matrix4().elements) };
    return seen ? { transform, emulatedPosition: guessed } : null;
  },
} as unknown as XRFrame;
export const BASE = {} as unknown as XRReferenceSpace;

class TestSession extends EventTarget {
  inputSources: XRInputSource[] = [];
  trackedSources: XRInputSource[] = [];
  visibilityState: XRVisibilityState = 'visible';
  interactionMode = 'world-space';
}

/** The pointers of a session, and its events. */
export class TestInputs {
  readonly session = new TestSession();
  readonly messages: string[] = [];
  /** Count of changes of the pointer that paints. */
  brushChanges = 0;
  readonly pointers: Pointers;
  private readonly poses = new Poses({ seen: true } as unknown as XRSpace);

  constructor(...sources: TestSource[]) {
    vi.stubGlobal('document', { createElement: () => ({ getContext: pen }) });
    this.session.inputSources = sources.map(({ xr }) => xr);
    this.pointers = new Pointers(
      this.session as unknown as XRSession,
      this.poses,
      new Rig(),
      new Scene(),
      new Lessons(),
      {
        brushGone: () => (this.brushChanges += 1),
        showMessage: (text) => this.messages.push(text),
      },
    );
    this.pointers.listen();
  }

  /** One picture. */
  advance(seconds = 0.01): void {
    this.poses.read(FRAME, BASE);
    this.pointers.update(FRAME, BASE, Float64Array.of(seconds));
  }

  change(added: TestSource[], removed: TestSource[] = [], type = 'inputsourceschange'): void {
    const event = new Event(type);
    const xr = (all: TestSource[]): XRInputSource[] => all.map((one) => one.xr);
    if (type === 'inputsourceschange') this.arrive(added, removed);
    this.session.dispatchEvent(Object.assign(event, { added: xr(added), removed: xr(removed) }));
  }

  /** Sources come and go, and no event says so. */
  arrive(added: TestSource[], removed: TestSource[] = []): void {
    const left = this.session.inputSources.filter((one) => !removed.some(({ xr }) => xr === one));
    this.session.inputSources = [...left, ...added.map(({ xr }) => xr)];
  }

  select(source: TestSource, down: boolean): void {
    const event = new Event(down ? 'selectstart' : 'selectend');
    this.session.dispatchEvent(Object.assign(event, { inputSource: source.xr }));
  }

  show(state: XRVisibilityState): void {
    this.session.visibilityState = state;
    this.session.dispatchEvent(new Event('visibilitychange'));
  }
}

/** A canvas's pen that draws nothing: words are for the eyes. */
function pen(): object {
  const nothing = (): void => undefined;
  return {
    canvas: {},
    measureText: () => ({ width: 1 }),
    beginPath: nothing,
    roundRect: nothing,
    fill: nothing,
    fillText: nothing,
  };
}
