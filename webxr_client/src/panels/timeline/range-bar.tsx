/** The part of a long recording that the timeline shows: a bar that is dragged, its ends too. */
import type { Signal } from '@preact/signals';
import { doubtfulFrames } from '../../store/cells';
import { state } from '../../store/state';
import { followPointer } from '../parts/drag';
import { clampSpan, pan, type Span, stretched } from './layout';

/** Least number of frames for the bar; with fewer, each frame is wide enough. */
const LONG = 240;
/** Pixels at either end of the bar that change how much is shown. */
const GRIP = 8;
/** Part of the visible stretch by which a key moves it. */
const STEP = 0.25;

interface RangeBarProps {
  span: Signal<Span>;
  frames: number;
  /** Pixels of names at the left. */
  gutter: number;
}

export function RangeBar({ span, frames, gutter }: RangeBarProps) {
  const { first, length } = span.value;
  if (frames < LONG && length >= frames) return null;
  const last = Math.min(frames, Math.ceil(first + length)) - 1;
  return (
    <div class="range-bar" style={{ marginLeft: `${gutter}px` }} onPointerDown={jump}>
      <Doubts frames={frames} />
      <div
        class="shown"
        role="scrollbar"
        tabIndex={0}
        aria-label="Frames shown"
        aria-orientation="horizontal"
        aria-controls="strips"
        aria-valuemin={0}
        aria-valuemax={frames - 1}
        aria-valuenow={Math.floor(first)}
        aria-valuetext={`Frames ${Math.floor(first)} to ${last}`}
        data-tip="Drag to scroll; drag an end, or turn the wheel over the strips, to zoom"
        style={{ left: `${(100 * first) / frames}%`, width: `${(100 * length) / frames}%` }}
        onPointerDown={(event) => drag(event, span, frames)}
        onDblClick={() => (span.value = { first: 0, length: frames })}
        onKeyDown={(event) => keys(event, span, frames)}
      />
    </div>
  );

  function jump(event: PointerEvent): void {
    if (event.button !== 0 || event.target !== event.currentTarget) return;
    const { left, width } = (event.currentTarget as HTMLElement).getBoundingClientRect();
    const at = ((event.clientX - left) / width) * frames;
    span.value = clampSpan({ first: at - length / 2, length }, frames);
  }
}

/** Marks of doubtful frames, which zooming does not redraw. */
function Doubts({ frames }: { frames: number }) {
  return doubtfulFrames(state.timeline.value.rows.values(), frames).map((frame) => (
    <i key={frame} style={{ left: `${(100 * frame) / frames}%` }} />
  ));
}

function keys(event: KeyboardEvent, span: Signal<Span>, frames: number): void {
  const { length } = span.peek();
  const way = event.key === 'ArrowRight' ? 1 : event.key === 'ArrowLeft' ? -1 : 0;
  const size = event.key === 'ArrowUp' ? 1 / 2 : event.key === 'ArrowDown' ? 2 : 0;
  if (way === 0 && size === 0) return;
  event.preventDefault();
  event.stopPropagation();
  if (way !== 0) span.value = pan(span.peek(), way * STEP * length, frames);
  else span.value = stretched(span.peek(), (length * (size - 1)) / 2, 'both', frames);
}

function drag(event: PointerEvent, span: Signal<Span>, frames: number): void {
  if (event.button !== 0) return;
  const bar = event.currentTarget as HTMLElement;
  const { left, right } = bar.getBoundingClientRect();
  const framesOfPixel = frames / bar.parentElement!.clientWidth;
  const began = span.peek();
  const end =
    right - left < 3 * GRIP
      ? null
      : event.clientX < left + GRIP
        ? 'first'
        : event.clientX > right - GRIP
          ? 'last'
          : null;
  followPointer(event, (moved) => {
    const by = (moved.clientX - event.clientX) * framesOfPixel;
    span.value = end ? stretched(began, by, end, frames) : pan(began, by, frames);
  });
}
