/** The canvas of the timeline: scrub on the ruler, choose a range on the strips. */
import { type Signal, useSignal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { actions } from '../../store/actions';
import { theme } from '../../store/theme';
import { state } from '../../store/state';
import { frameRange, type FrameRange } from '../../store/range';
import { stripHover, stripPlace } from './strip-pointer';
import { DARK_INK, drawTimeline, LIGHT_INK, type StripInk, type TimelineSizes } from './draw';
import { followPointer } from '../parts/drag';
import { RangeBar } from './range-bar';
import { atNextPicture } from './next-picture';
import { pan, reveal, xToFrame, zoom, type Span } from './layout';
import { follow } from '../../store/watch';

/** A finger needs more room. */
const COARSE = matchMedia('(pointer: coarse)').matches;
const RULER = COARSE ? 40 : 26;
const ROW = COARSE ? 40 : 18;
/** Pixels below the last strip. */
const FOOT = 6;
const GUTTER_NARROW = 136;
/** The wheel over the strips of more frames changes how many are shown; over names it moves rows. */
const MOST_WHOLE = 60;

/** Labels that have points somewhere, the active one always. */
function shownLabels() {
  const { rows } = state.timeline.value;
  return state.palette.value.filter(
    (label) => rows.has(label.id) || label.id === state.activeLabel.value,
  );
}

export function Strips({ frames }: { frames: number }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const span = useSignal<Span>({ first: 0, length: frames });
  const scroll = useSignal(0);
  const size = useSignal({ width: 0, height: 0 });
  const rows = shownLabels().length;

  useEffect(() => {
    span.value = { first: 0, length: frames };
    frameRange.value = null;
  }, [frames, span]);

  useEffect(() => {
    const element = canvas.current!;
    const observer = new ResizeObserver(() => {
      size.value = { width: element.clientWidth, height: element.clientHeight };
    });
    observer.observe(element);
    const following = follow(() => {
      span.value = reveal(span.peek(), state.frame.value, frames);
    });
    const choosing = follow(() => {
      const row = shownLabels().findIndex((label) => label.id === state.activeLabel.value);
      const fit = rowsIn(size.peek().height);
      if (row >= 0 && fit > 0) {
        scroll.value = Math.min(row, Math.max(scroll.peek(), row - fit + 1));
      }
    });
    const { show, stop } = atNextPicture((paint: () => void) => paint());
    const redraw = follow(() => {
      const picture = {
        span: span.value,
        frames,
        frame: state.frame.value,
        loaded: state.loaded.value,
        range: frameRange.value,
        labels: shownLabels(),
        rows: state.timeline.value.rows,
        active: state.activeLabel.value,
        scroll: scroll.value,
      };
      const sizes = sizesOf(size.value);
      show(() => {
        const ratio = devicePixelRatio;
        element.width = Math.round(sizes.width * ratio);
        element.height = Math.round(sizes.height * ratio);
        const pen = element.getContext('2d')!;
        pen.scale(ratio, ratio);
        drawTimeline(pen, sizes, picture);
      });
    });
    const fonts = (): void => {
      size.value = { ...size.peek() };
    };
    void document.fonts.ready.then(fonts);
    return () => {
      observer.disconnect();
      following();
      choosing();
      redraw();
      stop();
    };
  }, [frames, scroll, size, span]);

  const frameAt = (event: MouseEvent): number => {
    const { gutter, width } = sizesOf(size.peek());
    return xToFrame(event.offsetX - gutter, span.peek(), width - gutter, frames);
  };
  const wheel = (event: WheelEvent): void =>
    turnWheel(event, { span, scroll, sizes: sizesOf(size.peek()), rows, frames });
  useEffect(() => {
    const element = canvas.current!;
    element.addEventListener('wheel', wheel, { passive: false });
    return () => element.removeEventListener('wheel', wheel);
  });

  return (
    <>
      <canvas
        ref={canvas}
        id="strips"
        class="strips"
        role="slider"
        tabIndex={0}
        aria-label="Playhead"
        aria-valuemin={0}
        aria-valuemax={frames - 1}
        aria-valuenow={state.frame.value}
        onPointerDown={(event) => drag(event, frameAt, scroll.peek())}
        onDblClick={() => (frameRange.value = null)}
        onPointerMove={(event) => {
          if (event.pointerType === 'touch' || event.offsetX < GUTTER_NARROW) return;
          const bottom = innerHeight - event.currentTarget.getBoundingClientRect().top + 6;
          const label = labelAt(event.offsetY, scroll.peek())?.id ?? null;
          stripHover.value = { frame: frameAt(event), label, x: event.clientX, bottom };
        }}
        onPointerLeave={() => (stripHover.value = null)}
        onContextMenu={(event) => {
          event.preventDefault();
          const label = labelAt(event.offsetY, scroll.peek());
          const frame = frameAt(event);
          stripHover.value = null;
          if (!label) return;
          actions.labels.selectLabel(label.id);
          stripPlace.value = { label: label.id, frame, x: event.clientX, y: event.clientY };
        }}
      />
      <RangeBar span={span} frames={frames} gutter={GUTTER_NARROW} />
    </>
  );
}

interface Turned {
  span: Signal<Span>;
  scroll: Signal<number>;
  sizes: TimelineSizes;
  rows: number;
  frames: number;
}

/** Over strips of many frames the wheel zooms, with Shift it pans; over names it moves the rows. */
function turnWheel(event: WheelEvent, { span, scroll, sizes, rows, frames }: Turned): void {
  event.preventDefault();
  const { gutter, width, height } = sizes;
  const inner = width - gutter;
  const sideways = event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY);
  const zooms = event.offsetX > gutter && frames > MOST_WHOLE;
  if (event.ctrlKey || event.altKey || (zooms && !sideways)) {
    const factor = Math.exp(-event.deltaY * 0.004);
    span.value = zoom(span.peek(), factor, event.offsetX - gutter, inner, frames);
  } else if (sideways) {
    const by = (event.deltaX || event.deltaY) / Math.max(1, inner);
    span.value = pan(span.peek(), by * span.peek().length, frames);
  } else {
    const most = Math.max(0, rows - rowsIn(height));
    scroll.value = Math.min(most, Math.max(0, scroll.peek() + Math.sign(event.deltaY)));
  }
}

/** The label of the strip at a height, or undefined on the ruler and below the last. */
function labelAt(offsetY: number, scroll: number) {
  const row = Math.floor((offsetY - RULER) / ROW) + scroll;
  return offsetY < RULER ? undefined : shownLabels()[row];
}

/** Strips that a height has room for. */
function rowsIn(height: number): number {
  return Math.floor((height - RULER - FOOT) / ROW);
}

/** Colours of the strips in the theme of now; reads a signal. */
export function inkNow(): StripInk {
  return theme.value === 'light' ? LIGHT_INK : DARK_INK;
}

function sizesOf({ width, height }: { width: number; height: number }): TimelineSizes {
  return {
    width,
    height,
    gutter: GUTTER_NARROW,
    ruler: RULER,
    row: ROW,
    font: '"Inter Variable", system-ui, sans-serif',
    fontSize: 11,
    ink: inkNow(),
  };
}

/** One drag with the left button: on names choose, on the ruler scrub, on the strips a range. */
function drag(event: PointerEvent, frameAt: (event: PointerEvent) => number, scroll: number): void {
  if (event.button !== 0) return;
  const start = frameAt(event);
  if (event.offsetX < GUTTER_NARROW) {
    const label = labelAt(event.offsetY, scroll);
    if (label) actions.labels.selectLabel(label.id);
    return;
  }
  const scrubbing = event.offsetY < RULER;
  let range: FrameRange | null = null;
  if (scrubbing) actions.time.seek(start, true);
  const move = (moved: PointerEvent): void => {
    const frame = frameAt(moved);
    if (scrubbing) {
      actions.time.seek(frame, true);
    } else if (range || frame !== start) {
      range = { from: start, to: frame };
      frameRange.value = range;
    }
  };
  followPointer(event, move, (released) => {
    if (!range) actions.time.seek(frameAt(released));
  });
}
