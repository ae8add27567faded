/** The timeline keeps its height, whatever it shows; its upper edge can be dragged. */
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { follow } from '../watch';

/** Pixels: transport, ruler and four strips; and with one strip, which is the least. */
export const TIMELINE_DEFAULT = 146;
export const TIMELINE_LEAST = 92;
/** Part of the window that stays with the picture. */
const MOST_OF_WINDOW = 0.6;
const STEP = 18;
const KEY = 'pointbrush.timeline-height';

export function clampHeight(height: number, windowHeight: number): number {
  const most = Math.max(TIMELINE_LEAST, MOST_OF_WINDOW * windowHeight);
  return Math.round(Math.min(most, Math.max(TIMELINE_LEAST, height)));
}

function kept(): number {
  try {
    return Number(localStorage.getItem(KEY)) || TIMELINE_DEFAULT;
  } catch {
    return TIMELINE_DEFAULT; // storage is switched off
  }
}

const height = signal(TIMELINE_DEFAULT);

function setHeight(wanted: number): void {
  height.value = clampHeight(wanted, innerHeight);
  try {
    localStorage.setItem(KEY, String(height.peek()));
  } catch {
    // It is kept until the page is left.
  }
}

/** The edge between picture and timeline. */
export function TimelineHandle() {
  useEffect(() => {
    height.value = clampHeight(kept(), innerHeight);
    return follow(() => {
      document.getElementById('timeline')!.style.height = `${height.value}px`;
    });
  }, []);
  return (
    <div
      class="timeline-handle"
      role="separator"
      tabIndex={0}
      aria-label="Height of the timeline"
      aria-orientation="horizontal"
      aria-valuemin={TIMELINE_LEAST}
      aria-valuenow={height.value}
      data-tip="Drag: height of the timeline"
      onPointerDown={drag}
      onDblClick={() => setHeight(TIMELINE_DEFAULT)}
      onKeyDown={(event) => {
        const step = event.key === 'ArrowUp' ? STEP : event.key === 'ArrowDown' ? -STEP : 0;
        if (step === 0) return;
        event.preventDefault();
        event.stopPropagation();
        setHeight(height.peek() + step);
      }}
    />
  );
}

function drag(event: PointerEvent): void {
  if (event.button !== 0) return;
  const handle = event.currentTarget as HTMLElement;
  const began = height.peek();
  const move = (moved: PointerEvent): void => setHeight(began + (event.clientY - moved.clientY));
  const up = (): void => {
    handle.removeEventListener('pointermove', move);
    handle.removeEventListener('pointerup', up);
    handle.removeEventListener('pointercancel', up);
  };
  handle.setPointerCapture(event.pointerId);
  handle.addEventListener('pointermove', move);
  handle.addEventListener('pointerup', up);
  handle.addEventListener('pointercancel', up);
}
