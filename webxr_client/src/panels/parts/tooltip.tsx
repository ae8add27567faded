/** One tooltip for the whole page, for elements with `data-tip` (and `data-keys`). */
import { signal } from '@preact/signals';
import { useEffect, useLayoutEffect, useRef } from 'preact/hooks';
import { limits } from '../../store/limits';
import { renamedKeys } from '../../store/own-keys';

interface Tip {
  readonly text: string;
  readonly keys: string;
  readonly at: DOMRect;
  /** The popover around it; the tooltip leaves its other options visible. */
  readonly popover: DOMRect | undefined;
}

const DELAY_MS = 400;
/** Pixels from the tooltip to its element, and to the edge of the window. */
const [APART, EDGE] = [6, 8];
const shown = signal<Tip | null>(null);

function explain(target: EventTarget | null): void {
  const hints = limits.peek()?.hints ?? true;
  const element =
    hints && target instanceof Element ? target.closest<HTMLElement>('[data-tip]') : null;
  shown.value = element && {
    text: element.dataset['tip']!,
    keys: element.dataset['keys'] ?? '',
    at: element.getBoundingClientRect(),
    popover: element.closest('.popover')?.getBoundingClientRect(),
  };
}

/** Beside the popover where there is room, else below the element or above it. */
function place(box: HTMLElement, { at, popover }: Tip): void {
  const { offsetWidth: width, offsetHeight: height } = box;
  const right = (popover?.right ?? innerWidth) + APART;
  const left = (popover?.left ?? 0) - APART - width;
  const beside = right + width + EDGE <= innerWidth ? right : left;
  const isBeside = popover !== undefined && beside >= EDGE;
  const below = at.bottom + APART;
  const under = below + height < innerHeight ? below : at.top - APART - height;
  const centred = at.left + (at.width - width) / 2;
  box.style.top = `${isBeside ? at.top + (at.height - height) / 2 : under}px`;
  box.style.left = `${isBeside ? beside : Math.max(EDGE, Math.min(centred, innerWidth - width - EDGE))}px`;
}

export function Tooltip() {
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => {
    let timer = 0;
    const over = (event: Event): void => {
      clearTimeout(timer);
      if (shown.peek()) explain(event.target);
      else timer = window.setTimeout(explain, DELAY_MS, event.target);
    };
    const focus = (event: Event): void => {
      if (event.target instanceof Element && event.target.matches(':focus-visible')) {
        explain(event.target);
      }
    };
    const leave = (): void => {
      clearTimeout(timer);
      shown.value = null;
    };
    const hooks: [string, (event: Event) => void][] = [
      ['pointerover', over],
      ['focusin', focus],
      ['focusout', leave],
      ['pointerdown', leave],
      ['keydown', leave],
    ];
    for (const [name, hook] of hooks) document.addEventListener(name, hook, true);
    return () => {
      leave();
      for (const [name, hook] of hooks) document.removeEventListener(name, hook, true);
    };
  }, []);
  const tip = shown.value;
  useLayoutEffect(() => {
    if (tip && box.current) place(box.current, tip);
  }, [tip]);
  if (!tip) return null;
  return (
    <div ref={box} class="tooltip line small" role="tooltip">
      <span>{tip.text}</span>
      {tip.keys && <span class="kbd">{renamedKeys.value.get(tip.keys) ?? tip.keys}</span>}
    </div>
  );
}
