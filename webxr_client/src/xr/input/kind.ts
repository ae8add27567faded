/** Interface of a kind of WebXR input.  A kind is one object of the table in `kinds.ts`. */
import type { Object3D, Vector3 } from 'three';
import { type Device, deviceFor } from './devices';

/** `near`: it paints at its place; `far`: where its ray first hits, and drags at that depth. */
export type Reach = 'near' | 'far';

/** A control of a controller. */
export type Spot = 'trigger' | 'squeeze' | 'pad' | 'primary' | 'secondary';
/** Places of the controls, in the grip's space. */
export type Spots = Readonly<Record<Spot, Vector3>> & {
  /** The way out of the pad. */
  readonly up: Vector3;
};

/** The visible model of an input. */
export interface Model {
  readonly object: Object3D;
  readonly spots?: Spots;
  /** It follows the grip; else it places itself in the headset's space. */
  readonly gripped: boolean;
  update?(frame: XRFrame, space: XRReferenceSpace): void;
  /** Meeting point of thumb and index finger, in the headset's space; false: not seen. */
  pinch?(out: Vector3): boolean;
  /** The tip of the index finger, in the headset's space; false: not seen. */
  fingertip?(out: Vector3): boolean;
  dispose(): void;
}

export interface Kind {
  /** As messages call it. */
  readonly name: string;
  is(source: XRInputSource): boolean;
  readonly reach: Reach;
  /** It comes to press and goes when it is let go. */
  readonly momentary: boolean;
  /** It stays between presses and is held somewhere: a palette can stand over it. */
  readonly holds: boolean;
  /** Its ray begins where one sees something, and is drawn. */
  readonly drawn: boolean;
  /** A pinch with the palm turned to the eyes is the system's. */
  readonly systemPinch: boolean;
  /** It connects and disconnects by itself, without messages. */
  readonly fleeting: boolean;
  /** Places of its buttons and pads. */
  device(source: XRInputSource): Device;
  /** Depth of its press, 0..1; `selecting`: between `selectstart` and `selectend`. */
  press(gamepad: Gamepad | null, device: Device, selecting: boolean): number;
  /** Create its model; null: none. */
  model(source: XRInputSource, device: Device): Model | null;
}

/** The value of a gamepad's button, 0..1; 0 where there is none. */
export function buttonValue(gamepad: Gamepad | null, button: number): number {
  return gamepad && button >= 0 ? (gamepad.buttons[button]?.value ?? 0) : 0;
}

/** An input that points from afar and only selects: nothing to see, no buttons besides. */
export const SELECTS = {
  reach: 'far',
  holds: false,
  drawn: false,
  systemPinch: false,
  fleeting: true,
  device: () => deviceFor(['generic-button'], 0, false),
  press: (_gamepad, _device, selecting) => (selecting ? 1 : 0),
  model: () => null,
} as const satisfies Partial<Kind>;
