/** Follow the pointer that presses an element, until it is released or (cancelled) taken away. */
export function followPointer(
  event: PointerEvent,
  move: (moved: PointerEvent) => void,
  end?: (ended: PointerEvent) => void,
): void {
  const element = event.currentTarget as HTMLElement;
  const abort = new AbortController();
  const { signal } = abort;
  const ended = (last: PointerEvent): void => {
    abort.abort();
    end?.(last);
  };
  // A fast drag leaves the element at once.
  element.setPointerCapture(event.pointerId);
  element.addEventListener('pointermove', move, { signal });
  element.addEventListener('pointerup', ended, { signal });
  element.addEventListener('pointercancel', ended, { signal });
}
