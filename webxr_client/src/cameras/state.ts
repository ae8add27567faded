/** State that the strip of cameras shares with the cloud: pictures and the place pointed at. */
import type { Camera } from '../protocol/values';
import type { Vec } from '../store/types';
import { signal } from '@preact/signals';
import type { CloudFrame } from '../cloud/points/frame';

export interface Pointed {
  /** Local metres. */
  readonly place: Vec;
  /** Place in it that one points at. */
  readonly by: 'cloud' | 'picture';
}

/** Pictures of a frame. */
export interface Pictures {
  readonly sequence: string;
  readonly frame: number;
  readonly cameras: readonly Camera[];
  /** The page draws the one picture, of a depth camera without other pictures. */
  readonly drawn: boolean;
}

/** Choice of the user; null: open where cameras took pictures. */
export const stripOpen = signal<boolean | null>(null);
/** Name of the camera with the large picture over the cloud; null: none. */
export const largeCamera = signal<string | null>(null);
/** The large picture shows labels as filled masks. */
export const maskShown = signal(false);
/** Grows with changes of labels, and with it the address of masks. */
export const labelChanges = signal(0);
/** Of the large picture, 0 to 1: less lets the cloud through. */
export const largeOpacity = signal(1);
/** Pictures of the frame on screen, or of one just before it; null until they are loaded. */
export const pictures = signal<Pictures | null>(null);
/** The frame with the projected points, and its version: another object at each change. */
export const projectedFrame = signal<{ readonly frame: CloudFrame; readonly version: number } | null>(null); // prettier-ignore
/** The place under the pointer, in the cloud or in a picture. */
export const pointed = signal<Pointed | null>(null);

export function pointAt(place: Vec, by: Pointed['by']): void {
  pointed.value = { place, by };
}

export function clearPointed(by: Pointed['by']): void {
  if (pointed.peek()?.by === by) pointed.value = null;
}

/** Stored numbers, as the first one and the length of each run. */
export type Runs = readonly (readonly [first: number, length: number])[];

/** A piece of a frame that has an edge in the pictures; null: none. */
export const questionPiece = signal<{ readonly frame: number; readonly runs: Runs } | null>(null);

/** Lines that are drawn over the pictures: ends two and two, local metres. */
export interface Outline {
  readonly color: string;
  readonly chosen: boolean;
  readonly dashed: boolean;
  readonly ends: readonly number[];
}

/** Of the boxes on screen. */
export const outlines = signal<readonly Outline[]>([]);
