/** Drawing the strips: the same code on the desk and on the panel in the room. */
import type { Label } from '../../protocol/messages';
import type { LoadedRange, TimelineRow } from '../../store/state';
import type { FrameRange } from '../../store/range';
import { type CellKind, wantsLook } from '../../store/cells';
import { frameToX, runs, ticks, type Run, type Span } from './layout';

export interface TimelinePicture {
  readonly span: Span;
  readonly frames: number;
  /** Null: the playhead is drawn elsewhere. */
  readonly frame: number | null;
  readonly loaded: readonly LoadedRange[];
  readonly range: FrameRange | null;
  readonly labels: readonly Label[];
  readonly rows: ReadonlyMap<number, TimelineRow>;
  readonly active: number;
  /** Rows scrolled away above. */
  readonly scroll: number;
}

export interface TimelineSizes {
  readonly width: number;
  readonly height: number;
  /** Room for names at the left; 0 for none. */
  readonly gutter: number;
  readonly ruler: number;
  readonly row: number;
  readonly font: string;
  readonly fontSize: number;
  readonly ink: StripInk;
}

/** Colours of the strips; the contrast of text on each background is above 4.5. */
export interface StripInk {
  readonly back: `#${string}`;
  readonly lane: `#${string}`;
  readonly laneActive: `#${string}`;
  readonly line: `#${string}`;
  readonly text: `#${string}`;
  readonly textStrong: `#${string}`;
  readonly loaded: `#${string}`;
  readonly loadedPart: `#${string}`;
  readonly range: string;
  readonly rangeEdge: `#${string}`;
  readonly playhead: `#${string}`;
  readonly bad: `#${string}`;
}

/** In the dark theme, and in the headset. */
export const DARK_INK: StripInk = {
  back: '#12161b',
  lane: '#191e25',
  laneActive: '#222932',
  line: '#38424e',
  text: '#aeb8c4',
  textStrong: '#e9edf2',
  loaded: '#3d6ea8',
  loadedPart: '#2c3f57',
  range: 'rgba(94, 162, 255, 0.16)',
  rangeEdge: '#5ea2ff',
  playhead: '#ffffff',
  bad: '#ff7b72',
};

export const LIGHT_INK: StripInk = {
  back: '#fbfcfd',
  lane: '#edf1f5',
  laneActive: '#dfe6ee',
  line: '#aab5c2',
  text: '#36424d',
  textStrong: '#16202b',
  loaded: '#5b93d3',
  loadedPart: '#bcd3ee',
  range: 'rgba(27, 102, 201, 0.16)',
  rangeEdge: '#1b66c9',
  playhead: '#16202b',
  bad: '#c0312a',
};

/** Opacity of the name of a hidden label: still legible. */
export const HIDDEN = 0.75;

const SOLIDITY: Record<CellKind, number> = {
  none: 0,
  tracked: 0.8,
  painted: 1,
  occluded: 0.22,
  doubtful: 0.5,
  lost: 0.22,
};

/** Opacity of a tracked stretch, as a share of the most: half where it is least sure. */
function shadeOf(sure: number): number {
  return Math.max(0.4, 0.3 + 0.7 * sure);
}

/** Pixels that a doubtful frame has at least, and below which it is red all over. */
const [LEAST_DOUBT, NARROW] = [3, 6];

type Pen = CanvasRenderingContext2D;

export function drawTimeline(pen: Pen, sizes: TimelineSizes, picture: TimelinePicture): void {
  const { width, height, gutter, ruler, row, ink } = sizes;
  const inner = width - gutter;
  pen.fillStyle = ink.back;
  pen.fillRect(0, 0, width, height);
  pen.save();
  pen.beginPath();
  pen.rect(0, ruler, width, height - ruler);
  pen.clip();
  picture.labels.forEach((label, index) => {
    const top = ruler + (index - picture.scroll) * row;
    if (top + row <= ruler || top >= height) return;
    drawLane(pen, sizes, picture, label, top);
  });
  pen.restore();
  pen.save();
  pen.beginPath();
  pen.rect(gutter, 0, inner, height);
  pen.clip();
  pen.translate(gutter, 0);
  drawRange(pen, sizes, picture, inner);
  drawRuler(pen, sizes, picture, inner);
  drawPlayhead(pen, sizes, picture, inner);
  pen.restore();
}

/** A stretch of each kind, as the legend shows it. */
export function drawSample(
  pen: Pen,
  run: Pick<Run, 'kind' | 'sure'>,
  color: string,
  width: number,
  height: number,
  ink: StripInk,
): void {
  pen.fillStyle = ink.lane;
  pen.fillRect(0, 0, width, height);
  drawRun(pen, run, color, 0, 0, width, height, ink);
}

function drawLane(
  pen: Pen,
  sizes: TimelineSizes,
  picture: TimelinePicture,
  label: Label,
  top: number,
): void {
  const { width, gutter, row, font, fontSize, ink } = sizes;
  const inner = width - gutter;
  const active = label.id === picture.active;
  const gap = Math.max(1, Math.round(row * 0.12));
  pen.fillStyle = active ? ink.laneActive : ink.lane;
  pen.fillRect(gutter, top + gap, inner, row - gap);
  if (gutter > 0) drawName(pen, label, active, top + gap, sizes);
  const cells = picture.rows.get(label.id);
  if (!cells) return;
  pen.save();
  pen.beginPath();
  pen.rect(gutter, top + gap, inner, row - gap);
  pen.clip();
  const found = runs(cells, picture.span, picture.frames, inner);
  // Doubtful frames lie over their neighbours, and are wide enough to be seen.
  for (const looks of [false, true]) {
    for (const run of found) {
      if (wantsLook(run.kind) !== looks) continue;
      const [left, wide] = placeOf(run, picture.span, inner);
      drawRun(pen, run, label.color, gutter + left, top + gap, wide, row - gap, ink);
    }
  }
  pen.restore();
  pen.font = `500 ${fontSize}px ${font}`;
}

/** Left edge and width of a run, pixels. */
export function placeOf(
  run: Run,
  span: Span,
  inner: number,
): readonly [left: number, wide: number] {
  const left = frameToX(run.from, span, inner);
  const wide = frameToX(run.to, span, inner) - left;
  const least = wantsLook(run.kind) ? LEAST_DOUBT : 1;
  return wide >= least ? [left, wide] : [left + (wide - least) / 2, least];
}

function drawName(
  pen: Pen,
  label: Label,
  active: boolean,
  top: number,
  sizes: TimelineSizes,
): void {
  const { gutter, row, font, fontSize, ink } = sizes;
  const middle = top + row / 2 - 1;
  const swatch = Math.round(fontSize * 0.72);
  pen.globalAlpha = label.visible ? 1 : HIDDEN;
  pen.fillStyle = label.color;
  pen.fillRect(fontSize, middle - swatch / 2, swatch, swatch);
  pen.font = `${active ? 600 : 400} ${fontSize}px ${font}`;
  pen.textBaseline = 'middle';
  pen.textAlign = 'left';
  pen.fillStyle = active ? ink.textStrong : ink.text;
  const left = fontSize + swatch + fontSize * 0.7;
  pen.fillText(ellipsis(pen, label.name, gutter - left - 8), left, middle + 0.5);
  pen.globalAlpha = 1;
}

function drawRun(
  pen: Pen,
  { kind, sure }: Pick<Run, 'kind' | 'sure'>,
  color: string,
  left: number,
  top: number,
  width: number,
  height: number,
  ink: StripInk,
): void {
  pen.globalAlpha = SOLIDITY[kind] * (sure === undefined ? 1 : shadeOf(sure));
  pen.fillStyle = kind === 'lost' ? ink.bad : color;
  pen.fillRect(left, top, width, height);
  pen.globalAlpha = 1;
  if (!wantsLook(kind)) return;
  if (width < NARROW) {
    pen.fillStyle = ink.bad;
    pen.fillRect(left, top, width, height);
    return;
  }
  hatch(pen, left, top, width, height, ink.bad);
}

/** Draw red diagonals over a doubtful stretch. */
function hatch(
  pen: Pen,
  left: number,
  top: number,
  width: number,
  height: number,
  color: string,
): void {
  const gap = Math.max(4, height * 0.45);
  pen.save();
  pen.beginPath();
  pen.rect(left, top, width, height);
  pen.clip();
  pen.strokeStyle = color;
  pen.lineWidth = Math.max(1.5, height * 0.12);
  pen.beginPath();
  const start = Math.floor((left - height) / gap) * gap;
  for (let x = start; x < left + width; x += gap) {
    pen.moveTo(x, top + height);
    pen.lineTo(x + height, top);
  }
  pen.stroke();
  pen.restore();
}

function drawRange(pen: Pen, sizes: TimelineSizes, picture: TimelinePicture, inner: number): void {
  if (!picture.range) return;
  const { ink } = sizes;
  const { from, to } = picture.range;
  const left = frameToX(Math.min(from, to), picture.span, inner);
  const right = frameToX(Math.max(from, to) + 1, picture.span, inner);
  pen.fillStyle = ink.range;
  pen.fillRect(left, 0, right - left, sizes.height);
  pen.fillStyle = ink.rangeEdge;
  pen.fillRect(left, 0, 1.5, sizes.height);
  pen.fillRect(right - 1.5, 0, 1.5, sizes.height);
}

function drawRuler(pen: Pen, sizes: TimelineSizes, picture: TimelinePicture, inner: number): void {
  const { ruler, font, fontSize, ink } = sizes;
  const { span, frames } = picture;
  const bar = Math.max(2, Math.round(ruler * 0.12));
  pen.fillStyle = ink.lane;
  pen.fillRect(0, ruler - bar, inner, bar);
  for (const { first, last, complete } of picture.loaded) {
    const left = frameToX(first, span, inner);
    pen.fillStyle = complete ? ink.loaded : ink.loadedPart;
    pen.fillRect(left, ruler - bar, Math.max(1, frameToX(last + 1, span, inner) - left), bar);
  }
  pen.font = `400 ${fontSize}px ${font}`;
  pen.textBaseline = 'middle';
  pen.textAlign = 'center';
  for (const { frame, major } of ticks(span, inner, frames)) {
    const x = Math.round(frameToX(frame + 0.5, span, inner));
    const height = major ? ruler * 0.28 : ruler * 0.14;
    pen.fillStyle = ink.line;
    pen.fillRect(x, ruler - bar - height, 1, height);
    if (!major) continue;
    pen.fillStyle = ink.text;
    const text = String(frame);
    const half = pen.measureText(text).width / 2 + 2;
    pen.fillText(text, Math.min(inner - half, Math.max(half, x)), ruler * 0.33);
  }
}

function drawPlayhead(
  pen: Pen,
  sizes: TimelineSizes,
  picture: TimelinePicture,
  inner: number,
): void {
  if (picture.frame === null) return;
  const { ruler, height, font, fontSize, ink } = sizes;
  const x = Math.round(frameToX(picture.frame + 0.5, picture.span, inner));
  if (x < 0 || x > inner) return;
  pen.font = `600 ${fontSize}px ${font}`;
  const text = String(picture.frame);
  const width = pen.measureText(text).width + fontSize;
  const tall = ruler * 0.66;
  const left = Math.min(inner - width, Math.max(0, x - width / 2));
  pen.fillStyle = ink.playhead;
  pen.fillRect(x - 0.75, tall, 1.5, height - tall);
  pen.beginPath();
  pen.roundRect(left, 0, width, tall, fontSize * 0.3);
  pen.fill();
  pen.fillStyle = ink.back;
  pen.textBaseline = 'middle';
  pen.textAlign = 'center';
  pen.fillText(text, left + width / 2, tall / 2 + 0.5);
}

/**
 * The text cut with "…" so that it is at most `width` wide in the pen's font; a short last word, a
 * number as a rule, stays.
 */
export function ellipsis(pen: Pen, text: string, width: number): string {
  if (pen.measureText(text).width <= width) return text;
  const last = /\S\s(\S{1,5})$/u.exec(text)?.[1] ?? '';
  let end = text.length - last.length;
  while (end > 0 && pen.measureText(`${text.slice(0, end)}…${last}`).width > width) end--;
  return `${text.slice(0, end).trimEnd()}…${last}`;
}
