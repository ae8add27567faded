/** Three views of the chosen box along its axes, to one another as drawings are, with handles. */
import { useEffect, useRef, useState } from 'preact/hooks';
import { parseColor, type Rgb } from '../common/colors';
import { metres, plural } from '../common/format';
import { activeLabel, canEdit, state } from '../store/state';
import { chosenBox, type ObjectBox } from '../store/boxes';
import { theme } from '../store/theme';
import { commitDraft, dragTo, shownIn } from './changes';
import { FARTHEST, near, NEAREST, reachOf, zoom, type Near } from './near';
import { drawNear, scaleOf, type Scale } from './projected';
import {
  BOX_VIEWS,
  draggedIn,
  intoBox,
  placeOn,
  type BoxView,
  type Shape,
  type Side,
  type ViewHandle,
} from './shape';

/** A notch of the wheel shows so many times as much. */
const NOTCH = 1.15;
/** Pixels from the box to the knob that turns it. */
const KNOB = 20;
/** Labels' colours on light ground are darker by this. */
const DARKER = 0.68;
/** Fewer points than these are drawn larger. */
const FEW = 6000;
/** Colours of points outside, and of points in the box with another label, by theme. */
const GREYS: Readonly<Record<'dark' | 'light', readonly [Rgb, Rgb]>> = {
  dark: [
    [150, 160, 172],
    [255, 255, 255],
  ],
  light: [
    [84, 96, 110],
    [10, 16, 24],
  ],
};

export function BoxViews() {
  const around = near.value;
  const box = chosenBox.value;
  const shape = box && shownIn(box, state.shown.value.frame);
  if (!around || !box || !shape) return null;
  const wheel = (event: WheelEvent): void => {
    event.preventDefault();
    const next = zoom.peek() * NOTCH ** Math.sign(event.deltaY);
    zoom.value = Math.min(FARTHEST, Math.max(NEAREST, next));
  };
  return (
    <div class="box-views" onWheel={wheel}>
      {BOX_VIEWS.map((view) => (
        <View key={view.name} view={view} around={around} box={box} shape={shape} />
      ))}
    </div>
  );
}

interface ViewProps {
  view: BoxView;
  around: Near;
  box: ObjectBox;
  shape: Shape;
}

function View({ view, around, box, shape }: ViewProps) {
  const place = useRef<HTMLElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const [width, height] = useSize(place);
  const ratio = Math.min(2, devicePixelRatio);
  const scale = scaleOf(view, reachOf(around.anchor), width, height);
  const color = activeLabel.value?.color ?? '#ffffff';
  const [other, foreign] = GREYS[theme.value === 'light' ? 'light' : 'dark'];
  const [inside, setInside] = useState(0);
  useEffect(() => {
    const pen = canvas.current?.getContext('2d');
    if (!pen || width === 0) return;
    const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
    const pixels = pen.createImageData(w, h);
    const fine = { width: w, height: h, perMetre: scale.perMetre * ratio };
    const inks = { label: inkOf(color), other, foreign };
    setInside(drawNear(pixels, around, shape, box.label, view, fine, inks, dotOf(around)));
    pen.putImageData(pixels, 0, 0);
  }, [around, shape, box.label, view, width, height, scale.perMetre, color, other]);
  return (
    <figure ref={place} class={`box-view ${view.name.toLowerCase()}`}>
      <canvas ref={canvas} width={Math.round(width * ratio)} height={Math.round(height * ratio)} />
      {width > 0 && <Handles view={view} box={box} shape={shape} anchor={around.anchor} scale={scale} color={color} />}
      <figcaption>
        {view.name}
        <span class="soft number">
          {metres(shape.size[view.right])} × {metres(shape.size[view.up])}
          {view.name === 'Top' && ` · ${plural(inside, 'point')} inside`}
        </span>
      </figcaption>
    </figure>
  ); // prettier-ignore
}

/** A label's colour as points have it: legible on light ground, too. */
function inkOf(color: string): Rgb {
  const share = theme.value === 'light' ? DARKER : 1;
  const [red, green, blue] = parseColor(color);
  return [share * red, share * green, share * blue];
}

/** Pixels across a point: few are drawn larger. */
function dotOf({ labels }: Near): number {
  return Math.round((labels.length < FEW ? 3 : 2) * Math.min(2, devicePixelRatio));
}

/** Pixels of an element, as it is now. */
function useSize(of: { readonly current: HTMLElement | null }): readonly [number, number] {
  const [size, setSize] = useState<readonly [number, number]>([0, 0]);
  useEffect(() => {
    const observer = new ResizeObserver(([entry]) => {
      const { width, height } = entry!.contentRect;
      setSize([Math.round(width), Math.round(height)]);
    });
    observer.observe(of.current!);
    return () => observer.disconnect();
  }, []);
  return size;
}

type Pixel = readonly [number, number];

const SIDES: readonly (readonly [Side, Side])[] = [
  [1, 0], [0, 1], [-1, 0], [0, -1],
]; // prettier-ignore
/** One after another round the box. */
const CORNERS: readonly (readonly [Side, Side])[] = [
  [1, 1], [-1, 1], [-1, -1], [1, -1],
]; // prettier-ignore

interface HandlesProps extends Omit<ViewProps, 'around'> {
  anchor: Shape;
  scale: Scale;
  color: string;
}

function Handles({ view, box, shape, anchor, scale, color }: HandlesProps) {
  const grip = useRef<{ handle: ViewHandle; from: Pixel; start: Shape } | null>(null);
  const frame = state.shown.value.frame;
  const at = (right: Side, up: Side): Pixel => {
    const sides: [Side, Side, Side] = [0, 0, 0];
    sides[view.right] = right;
    sides[view.up] = up;
    const place = intoBox(anchor, placeOn(shape, sides));
    return onPicture(place[view.right], place[view.up], scale);
  };
  const inMetres = (event: PointerEvent): Pixel => {
    const bounds = (event.currentTarget as Element).closest('svg')!.getBoundingClientRect();
    const u = (event.clientX - bounds.left - scale.width / 2) / scale.perMetre;
    const v = (scale.height / 2 - (event.clientY - bounds.top)) / scale.perMetre;
    return [u, v];
  };
  const on = (handle: ViewHandle) => ({
    onPointerDown: (event: PointerEvent): void => {
      if (event.button !== 0 || !canEdit.peek()) return;
      event.preventDefault();
      (event.currentTarget as Element).setPointerCapture(event.pointerId);
      grip.current = { handle, from: inMetres(event), start: shape };
    },
    onPointerMove: (event: PointerEvent): void => {
      const held = grip.current;
      if (!held) return;
      dragTo(box, frame, draggedIn(view, held.handle, held.start, held.from, inMetres(event)));
    },
    onPointerUp: (): void => {
      if (grip.current) commitDraft();
      grip.current = null;
    },
    onPointerCancel: (): void => void (grip.current = null),
  });
  const corners = CORNERS.map(([right, up]) => at(right, up));
  const middle = at(0, 0);
  const front = at(1, 0);
  const length = Math.hypot(front[0] - middle[0], front[1] - middle[1]) || 1;
  const way = [(front[0] - middle[0]) / length, (front[1] - middle[1]) / length] as const;
  const knob: Pixel = [front[0] + KNOB * way[0], front[1] + KNOB * way[1]];
  return (
    <svg width={scale.width} height={scale.height} style={{ '--color': color }} role="group" aria-label={`${view.name} view of the box`}>
      <polygon class="box-inside" points={corners.map((pixel) => pixel.join()).join(' ')} data-handle="move" {...on('move')} />
      {box.heading_known && <polyline class="box-arrow" points={arrow(view, middle, front)} />}
      {SIDES.map(([right, up], i) => {
        const [a, b] = [corners[(i + 3) % 4]!, corners[i]!];
        const ends = { x1: a[0], y1: a[1], x2: b[0], y2: b[1] };
        const name = `${right} ${up}`;
        return (
          <g key={name} class={right === 0 ? 'box-side level' : 'box-side upright'}>
            <line {...ends} class={right === 1 && view.right === 0 && box.heading_known ? 'box-edge ahead' : 'box-edge'} />
            <line {...ends} class="box-hold" data-handle={name} {...on({ right, up })} />
          </g>
        );
      })}
      <line x1={front[0]} y1={front[1]} x2={knob[0]} y2={knob[1]} class="box-stalk" />
      <circle cx={knob[0]} cy={knob[1]} r={6} class="box-knob" data-handle="turn" {...on('turn')} />
      {CORNERS.map(([right, up], i) => {
        const [x, y] = corners[i]!;
        const lean = right === up ? 'rising' : 'falling';
        return <rect key={`${right} ${up}`} x={x - 4.5} y={y - 4.5} width={9} height={9} class={`box-corner ${lean}`} data-handle={`${right} ${up}`} {...on({ right, up })} />;
      })}
    </svg>
  ); // prettier-ignore
}

function onPicture(right: number, up: number, { width, height, perMetre }: Scale): Pixel {
  return [width / 2 + right * perMetre, height / 2 - up * perMetre];
}

/** Arrow from the middle of the box to its front; a point if the view faces the front. */
function arrow(view: BoxView, [x, y]: Pixel, [u, v]: Pixel): string {
  if (view.right !== 0) return '';
  const [dx, dy] = [(u - x) * 0.22, (v - y) * 0.22];
  const tip = [x + 0.85 * (u - x), y + 0.85 * (v - y)] as const;
  const barb = (side: number): string =>
    `${tip[0] - dx + side * dy * 0.6},${tip[1] - dy - side * dx * 0.6}`;
  return `${x},${y} ${tip.join()} ${barb(1)} ${tip.join()} ${barb(-1)}`;
}
