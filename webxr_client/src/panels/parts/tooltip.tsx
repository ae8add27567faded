/** One tooltip for the whole page: whatever has `data-tip` (and `data-keys`) is explained. */
import { signal } from '@preact/signals';
import { useEffect, useLayoutEffect, useRef } from 'preact/hooks';
import { renamedKeys } from '../../store/own-keys';

interface Tip {
  readonly text: string;
  readonly keys: string;
  readonly at: DOMRect;
}

const DELAY_MS = 400;
const shown = signal<Tip | null>(null);

function explain(target: EventTarget | null): void {
  const element = target instanceof Element ? target.closest<HTMLElement>('[data-tip]') : null;
  shown.value = element && {
    text: element.dataset['tip']!,
    keys: element.dataset['keys'] ?? '',
    at: element.getBoundingClientRect(),
  };
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
    if (!tip || !box.current) return;
    const { offsetWidth: width, offsetHeight: height } = box.current;
    const below = tip.at.bottom + 6;
    const top = below + height < innerHeight ? below : tip.at.top - 6 - height;
    const centred = tip.at.left + (tip.at.width - width) / 2;
    box.current.style.top = `${top}px`;
    box.current.style.left = `${Math.max(8, Math.min(centred, innerWidth - width - 8))}px`;
  }, [tip]);
  if (!tip) return null;
  return (
    <div ref={box} class="tooltip" role="tooltip">
      <span>{tip.text}</span>
      {tip.keys && <span class="kbd">{renamedKeys.value.get(tip.keys) ?? tip.keys}</span>}
    </div>
  );
}
