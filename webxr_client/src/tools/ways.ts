/**
 * The ways of taking points, one object each: tool bar, keys, pointer, controller and palette are
 * made from this table.
 */
import { peek } from '../store/watch';
import type { IconName } from '../common/icons';
import type { Brush } from '../protocol/messages';
import { state, type BrushShape } from '../store/state';
import { xrSettings } from '../store/xr-settings';

/** Name of a way: the shape of its strokes. */
export type WayName = NonNullable<Brush['shape']>;

export interface Way {
  readonly name: WayName;
  /** The setting of the brush that it belongs to. */
  readonly shape: BrushShape;
  readonly icon: IconName;
  /** On the palette in the room, and at the desk where it is there. */
  readonly label: string;
  readonly desk: { readonly label: string; readonly tip: string; readonly key: string } | null;
  /** Input of a pressed button or trigger: clicks, a path, one place, or something drawn. */
  readonly samples: 'clicks' | 'path' | 'once' | 'drawn';
  /** Source of its preview: the page, or the server; null: not shown before. */
  readonly preview: 'lit' | 'asked' | null;
  /** In the headset: takes points at the ray's first hit instead of at the tip. */
  readonly far: boolean;
  /** The name of its size; null when it has none. */
  readonly size: 'Radius' | 'Reach' | null;
  /** It can reach points behind the first surface. */
  readonly through: boolean;
}

/** Fill, clusters and planes: the server finds the points from one place. */
const FROM_PLACE = {
  samples: 'once',
  preview: 'asked',
  far: true,
  size: 'Reach',
  through: false,
} as const;
const DRAWN = { samples: 'drawn', preview: null, far: false, size: null, through: false } as const;
const BALL = { shape: 'brush', samples: 'path', preview: 'lit', size: 'Radius' } as const;

export const WAYS: readonly Way[] = [
  {
    ...FROM_PLACE,
    name: 'object',
    shape: 'object',
    icon: 'object',
    label: 'Object',
    desk: {
      label: 'Object',
      tip: 'Click an object; the wheel changes to a smaller or larger part',
      key: 'J',
    },
    samples: 'clicks',
    size: null,
  },
  { ...BALL, name: 'sphere', icon: 'brush', label: 'Ball', desk: null, far: false, through: false },
  {
    ...BALL,
    name: 'ray',
    icon: 'target',
    label: 'Ray',
    desk: { label: 'Brush', tip: 'Paint inside a ball on the surface', key: 'B' },
    far: true,
    through: true,
  },
  {
    ...FROM_PLACE,
    name: 'grow',
    shape: 'grow',
    icon: 'grow',
    label: 'Fill',
    desk: { label: 'Fill', tip: 'The connected region of the clicked point', key: 'K' },
    far: false,
  },
  {
    ...FROM_PLACE,
    name: 'cluster',
    shape: 'cluster',
    icon: 'cluster',
    label: 'Cluster',
    desk: { label: 'Cluster', tip: 'Connected points above the ground', key: 'H' },
  },
  {
    ...FROM_PLACE,
    name: 'plane',
    shape: 'plane',
    icon: 'plane',
    label: 'Ground',
    desk: { label: 'Ground', tip: 'A flat surface: a floor, a wall', key: 'G' },
  },
  {
    ...DRAWN,
    name: 'lasso',
    shape: 'lasso',
    icon: 'lasso',
    label: 'Lasso',
    desk: { label: 'Lasso', tip: 'All points inside an outline', key: 'O' },
  },
  {
    ...DRAWN,
    name: 'box',
    shape: 'box',
    icon: 'box',
    label: 'Box',
    desk: { label: 'Box', tip: 'Drag a box over the floor, adjust it, press Enter', key: 'M' },
  },
];

/** A way at the desk. */
export type DeskWay = Way & { readonly desk: NonNullable<Way['desk']> };

/** In the order of the tool bar. */
export const DESK_WAYS: readonly DeskWay[] = WAYS.filter(
  (way): way is DeskWay => way.desk !== null,
);

export function wayOf(name: WayName): Way {
  return WAYS.find((way) => way.name === name)!;
}

/** Shapes by which the hand in the room takes points. */
export function roomWay(): Way {
  const { shape } = peek(state.brush);
  const tip = peek(xrSettings).tip;
  return WAYS.find((way) => way.shape === shape && (shape !== 'brush' || way.name === tip))!;
}

/** Shapes by which the mouse takes points. */
export function deskWay(shape: BrushShape = state.brush.peek().shape): DeskWay {
  return DESK_WAYS.find((way) => way.shape === shape)!;
}

/** Whether a stroke is completed to the object that it lies on. */
export function completes(way: Way): boolean {
  return way.samples === 'path' && peek(state.brush).complete && peek(state.tool) === 'paint';
}
