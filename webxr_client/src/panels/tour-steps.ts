/** The tour as five cards: their texts and controls, and whether the user has seen them. */
import { signal } from '@preact/signals';
import { keep } from '../store/kept';

export interface TourStep {
  readonly title: string;
  readonly text: string;
  /** Selector of the control that the card points at. */
  readonly at: string;
  /** The step is about editing and is left out for viewers. */
  readonly edits: boolean;
  /** The control exists only while the shape is `object`. */
  readonly objects?: true;
}

const TOUR: readonly TourStep[] = [
  {
    title: 'Look around',
    text: 'Drag with the right button to move the view, hold Alt and drag to turn it, and use the wheel to zoom. With Look, the left button turns the view.',
    at: '.tools [aria-label="Look"]',
    edits: false,
  },
  {
    title: 'Choose a label',
    text: 'A label is one object, such as “pin 1”, or one class. Press N to make a label and type its name. Click a row to choose its label.',
    at: '#palette',
    edits: true,
  },
  {
    title: 'Paint an object',
    text: 'The Object tool is active. Point at an object to highlight it, use the wheel for a smaller or larger part, and click to paint it.',
    at: '#toolbar .options [aria-label="Object"]',
    edits: true,
    objects: true,
  },
  {
    title: 'Track it',
    text: 'Tracking finds the label in the other frames. Press , and . to go to the doubtful frames.',
    at: '.track-button',
    edits: true,
  },
  {
    title: 'Export',
    text: 'Download points and labels as files for other programs. Press ? to see all keys and to repeat this tour.',
    at: '.export-button',
    edits: false,
  },
];

export function stepsFor(canEdit: boolean): readonly TourStep[] {
  return TOUR.filter(({ edits }) => canEdit || !edits);
}

/** The card that is open, counted from 0; null: none. */
export const tourStep = signal<number | null>(null);

const KEY = 'pointbrush.tour';

/** Return whether the tour was never left in this browser; false in a browser without storage. */
export function tourIsNew(): boolean {
  try {
    return localStorage.getItem(KEY) === null;
  } catch {
    return false;
  }
}

export function beginTour(): void {
  tourStep.value = 0;
}

export function leaveTour(): void {
  tourStep.value = null;
  keep(KEY, 'left');
}

/** Go on or back by cards; past the last of `count` the tour is over. */
export function stepTour(by: number, count: number): void {
  const step = tourStep.peek();
  if (step === null) return;
  if (step + by >= count) leaveTour();
  else tourStep.value = Math.max(0, step + by);
}

export interface Box {
  readonly left: number;
  readonly top: number;
  readonly width: number;
  readonly height: number;
}

type Size = Pick<Box, 'width' | 'height'>;

export interface CardPlace {
  readonly left: number;
  readonly top: number;
  /** Side of the control on which the card lies. */
  readonly side: 'below' | 'right';
  /** From the card's corner to the tip that points at the control, along the edge. */
  readonly tip: number;
}

/** Pixels between control and card, between card and window, and from a corner to the tip. */
const GAP = 12;
const MARGIN = 8;
const CORNER = 20;

/** Return the card's place: below a control, or beside it where the control is taller than the rest. */
export function placeCard(control: Box, card: Size, window: Size): CardPlace {
  const within = (value: number, most: number): number => Math.max(MARGIN, Math.min(value, most - MARGIN)); // prettier-ignore
  const below = control.top + control.height + GAP;
  if (below + card.height + MARGIN <= window.height) {
    const middle = control.left + control.width / 2;
    const left = within(middle - CORNER, window.width - card.width);
    return { left, top: below, side: 'below', tip: clampTip(middle - left, card.width) };
  }
  const left = within(control.left + control.width + GAP, window.width - card.width);
  const top = within(control.top + CORNER, window.height - card.height);
  return { left, top, side: 'right', tip: CORNER };
}

function clampTip(tip: number, edge: number): number {
  return Math.max(CORNER, Math.min(tip, edge - CORNER));
}
