/** State that the strip of cameras shares with the cloud: pictures, and the place under the pointer. */
import type { Camera } from '../protocol/values';
import type { Vec } from '../store/types';
import { signal } from '@preact/signals';
import type { CloudFrame } from '../cloud/points/frame';

export interface Pointed {
  /** Local metres. */
  readonly place: Vec;
  /** View that the pointer is in. */
  readonly by: 'cloud' | 'picture';
}

/** Pictures of a frame. */
export interface Pictures {
  readonly sequence: string;
  readonly frame: number;
  readonly cameras: readonly Camera[];
  /** The one picture is that of a depth camera, which the page draws from its points. */
  readonly drawn: boolean;
}

/** Whether the user opened the strip; null: it is open if the recording has pictures. */
export const stripOpen = signal<boolean | null>(null);
/** Name of the camera with the large picture over the cloud; null: none. */
export const largeCamera = signal<string | null>(null);
/** Whether the large picture shows labels as filled areas. */
export const maskShown = signal(false);
/** Number of changes of labels, after each of which masks are loaded again. */
export const labelChanges = signal(0);
/** Opacity of the large picture over the cloud, 0 to 1. */
export const largeOpacity = signal(1);
/** Pictures of the frame on screen, or of one just before it; null until they are loaded. */
export const pictures = signal<Pictures | null>(null);
/** The frame with the projected points, and its version; a new object after each change. */
export const projectedFrame = signal<{ readonly frame: CloudFrame; readonly version: number } | null>(null); // prettier-ignore
/** The place under the pointer, in the cloud or in a picture. */
export const pointed = signal<Pointed | null>(null);

export function pointAt(place: Vec, by: Pointed['by']): void {
  pointed.value = { place, by };
}

export function clearPointed(by: Pointed['by']): void {
  if (pointed.peek()?.by === by) pointed.value = null;
}

/** Stored numbers of points, as the first number and the length of each run. */
export type Runs = readonly (readonly [first: number, length: number])[];

/** The piece of a frame that a question is about: pictures show its edge; null: none. */
export const questionPiece = signal<{ readonly frame: number; readonly runs: Runs } | null>(null);

/** Lines over the pictures; `ends`: coordinates of pairs of ends, local metres. */
export interface Outline {
  readonly color: string;
  readonly chosen: boolean;
  readonly dashed: boolean;
  readonly ends: readonly number[];
}

/** Outlines of the boxes on screen. */
export const outlines = signal<readonly Outline[]>([]);
